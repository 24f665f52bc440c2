"""A window of a recording: what is in it, for statistics of a slide."""

from __future__ import annotations

import numpy as np
import xarray as xr

from frictionloop.identification.recording_columns import channel, rate_of
from frictionloop.quantities import Array

_EARLY = 1e-6  # of a sampling interval: times are rounded


def window(
    recording: xr.Dataset, start_s: float, stop_s: float, units: dict[str, str]
) -> tuple[Array, list[Array], float]:
    """Return times and columns from start_s up to, not including, stop_s, and the sampling rate in Hz."""
    columns = [channel(recording, name, (unit,)) for name, unit in units.items()]
    rate_hz, time = rate_of(recording), np.asarray(recording["time"].values, dtype=float)
    first, last = (s - _EARLY / rate_hz for s in (start_s, stop_s))
    begin, end = (int(np.searchsorted(time, s)) for s in (first, last))
    return time[begin:end], [column[begin:end] for column in columns], rate_hz
