"""Recordings of one weight each, as the table of a calibration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.channels import READING
from frictionloop.identification.long import Run
from frictionloop.quantities import FrictionloopError


def hung(runs: Sequence[Run], masses_kg: NDArray[np.float64]) -> xr.Dataset:
    """Return a row for each weight: its mass in kg, and the mean of every channel while it hung.

    Parameters
    ----------
    runs : sequence of xarray.Dataset
        What was recorded under each weight, all of it: nothing is left out at its beginning.
    masses_kg : array
        In the same order.

    Raises
    ------
    FrictionloopError
        For another number of masses than of recordings, or recordings without a reading.
    """
    if len(runs) != masses_kg.size:
        raise FrictionloopError(
            f"there are {masses_kg.size} masses and {len(runs)} recordings of {READING!r}: must be as many"
        )
    whole = [run for run in runs if isinstance(run, xr.Dataset)]
    if any(READING not in run for run in whole):
        there = ", ".join(map(str, whole[0].data_vars))
        raise FrictionloopError(f"recording has no column {READING!r}; there: {there}")
    rows = {
        str(name): ("row", np.array([float(run[name].mean()) for run in whole]), whole[0][name].attrs)
        for name in whole[0].data_vars
        if name != "mass"
    }
    return xr.Dataset({"mass": ("row", masses_kg, {"units": "kg"}), **rows}, attrs=whole[0].attrs)
