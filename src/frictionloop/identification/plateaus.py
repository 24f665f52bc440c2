"""The steps of a calibration: what a sensor reads while each mass hangs still."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.channels import READING, READING_UNITS, channel, rate_of
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import number

Array = NDArray[np.float64]


class Plateaus(NamedTuple):
    """Means of the reading over the time a mass hangs still, in the order of the recording; arrays of one shape."""

    mass_kg: Array
    reading: Array
    """In ``unit``."""
    direction: Array
    """1 if the mass had grown, -1 if it had shrunk, 0 for the first."""
    unit: str
    moves: Array
    """Standard deviation of the slow movement of the reading while a mass hangs, its swing; 0 of a table."""
    at_ends: Array
    """Share of the samples of a step at its least and at its largest value, shape (steps, 2); 0 of a table."""


def plateaus(recording: xr.Dataset, settle_s: float = 1.0) -> Plateaus:
    """Return the steps of a calibration: where ``mass`` (kg) stays the same, the mean of ``f_m`` once it is still.

    The rows of a table are such steps as they stand.

    Parameters
    ----------
    recording : xarray.Dataset
        Columns ``mass`` in kg and ``f_m`` in N, V or counts, over ``time`` in s, or over ``row``.
    settle_s : float
        Time left out after each change of mass in s, not negative.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, a negative mass, fewer than three steps, all of one mass, or a
        step that does not last longer than ``settle_s``.
    """
    if isinstance(recording, xr.Dataset) and "row" in recording.dims:
        return _rows(recording)
    mass = channel(recording, "mass", ("kg",))
    reading = channel(recording, READING, READING_UNITS)
    rate_hz = rate_of(recording)
    number("settle_s", settle_s, "s", 0.0)
    if np.any(mass < 0):
        raise FrictionloopError(f"recording: 'mass' is {mass.min():g} kg: must be at least 0")
    starts = np.concatenate([[0], np.flatnonzero(np.diff(mass)) + 1])
    ends = np.concatenate([starts[1:], [mass.size]])
    if starts.size < 3 or np.ptp(mass) == 0:
        raise FrictionloopError(f"recording: 'mass' has {starts.size} steps: must have at least three")
    shortest = int(np.argmin(ends - starts))
    lasts_s = (ends[shortest] - starts[shortest]) / rate_hz
    skipped = math.ceil(settle_s * rate_hz)
    if ends[shortest] - starts[shortest] <= skipped:
        raise FrictionloopError(
            f"settle_s = {settle_s:g} s: must be below {lasts_s:g}, the time that {mass[starts[shortest]]:g} kg hangs "
            f"from row {starts[shortest]} on"
        )
    hanging = [reading[a + skipped : b] for a, b in zip(starts, ends, strict=True)]
    means = np.array([each.mean() for each in hanging])
    moves = np.array([np.std([part.mean() for part in np.array_split(each, 10) if part.size]) for each in hanging])
    levels = mass[starts]
    direction = np.concatenate([[0.0], np.sign(np.diff(levels))])
    at_ends = np.array([[np.mean(each == end) for end in (each.min(), each.max())] for each in hanging])
    return Plateaus(levels, means, direction, str(recording[READING].attrs["units"]), moves, at_ends)


def _rows(table: xr.Dataset) -> Plateaus:
    mass = channel(table, "mass", ("kg",), dim="row")
    reading = channel(table, READING, READING_UNITS, dim="row")
    if mass.size < 3 or np.ptp(mass) == 0 or mass.min() < 0:
        raise FrictionloopError(
            f"recording: 'mass' has {mass.size} rows from {mass.min():g} to {mass.max():g} kg: must have at least "
            "three, none below 0, not all alike"
        )
    direction = np.concatenate([[0.0], np.sign(np.diff(mass))])
    unit, none = str(table[READING].attrs["units"]), np.zeros_like(reading)
    return Plateaus(mass, reading, direction, unit, none, np.zeros((reading.size, 2)))
