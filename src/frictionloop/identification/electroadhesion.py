"""Recordings of electroadhesion, which raises friction with the command, are refused by name."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]


def refuse_electroadhesion(recording: xr.Dataset, force: Array) -> None:
    """Refuse a recording whose friction rises with its ``amplitude``."""
    if "amplitude" not in recording:
        return
    amplitude = np.abs(np.asarray(recording["amplitude"].values, dtype=float))
    if np.ptp(amplitude) > 0 and float(np.corrcoef(amplitude, np.abs(force))[0, 1]) > 0.5:
        raise FrictionloopError(
            "recording: friction rises with 'amplitude', as electroadhesion makes it: accepted are recordings of "
            "ultrasonic vibration, which lowers friction"
        )
