"""A window of a recording: what is in it, checked, for statistics of a slide."""

from __future__ import annotations

import numpy as np
import xarray as xr

from frictionloop.identification.channels import Array, channel, rate_of
from frictionloop.quantities import FrictionloopError

LEAST_RATE_HZ = 1000.0
"""Sampling rate below which neither fluctuations up to 100 Hz nor a slip of milliseconds can be told (assumed)."""
_EARLY = 1e-6  # of a sampling interval: times are rounded


def window(
    recording: xr.Dataset, start_s: float, stop_s: float, units: dict[str, str]
) -> tuple[Array, list[Array], float]:
    """Return times and columns from start_s up to, not including, stop_s, and the sampling rate in Hz.

    Parameters
    ----------
    recording : xarray.Dataset
        Columns over ``time`` in s, each with its unit.
    start_s, stop_s : float
        Window in s, inside the recording.
    units : dict
        Names of the columns wanted and the unit that each must have.

    Raises
    ------
    FrictionloopError
        For a column or time that cannot be used, a slow rate, or a window that is empty or reaches beyond.
    """
    columns = [channel(recording, name, (unit,)) for name, unit in units.items()]
    rate_hz, time = rate_of(recording), np.asarray(recording["time"].values, dtype=float)
    if rate_hz < LEAST_RATE_HZ:
        raise FrictionloopError(f"recording: sampled at {rate_hz:g} Hz: must be at least {LEAST_RATE_HZ:g} Hz")
    first, last = (s - _EARLY / rate_hz for s in (start_s, stop_s))
    begin, end = (int(np.searchsorted(time, s)) for s in (first, last))
    if not (first >= time[0] - 2 * _EARLY / rate_hz and begin < end and last <= time[-1] + 1.0 / rate_hz):
        raise FrictionloopError(
            f"start_s = {start_s:g}, stop_s = {stop_s:g}: must be in this order and within the recording, "
            f"{time[0]:g} to {time[-1] + 1.0 / rate_hz:g} s"
        )
    return time[begin:end], [column[begin:end] for column in columns], rate_hz


def mean_of(name: str, values: Array) -> float:
    """Return the mean in N, refusing one that is not above 0."""
    mean = float(values.mean())
    if not mean > 0:
        raise FrictionloopError(f"recording: {name!r} is {mean:.3g} N on average: must be above 0")
    return mean
