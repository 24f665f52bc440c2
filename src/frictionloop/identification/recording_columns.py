"""Columns of a recording as arrays: named, in the unit they say, evenly sampled, without gaps."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.quantities import Array, FrictionloopError, must_be
from frictionloop.recordings.friction_defects import stretches

READING = "f_m"
"""Name of the sensor's reading, as in a run of the loop."""
READING_UNITS = ("N", "V", "counts")
_UNEVEN = 1e-3  # of a sampling interval


def no_column(name: str, recording: xr.Dataset) -> FrictionloopError:
    """Return the error that a column is not there, naming those that are."""
    there = ", ".join(map(str, recording.data_vars)) or "none"
    return FrictionloopError(f"recording: no column {name!r}: accepted {there}", "UNKNOWN-NAME")


def channel(recording: xr.Dataset, name: str, units: tuple[str, ...], dim: str = "time") -> Array:
    """Return a column over time, refusing one that is not there, has another unit, or holds no finite numbers.

    Parameters
    ----------
    recording : xarray.Dataset
        Variables over ``time``, each with an attribute ``units``.
    name : str
        Column.
    units : tuple of str
        Units accepted.
    dim : str
        ``"time"``, or ``"row"`` for a plain table.

    Raises
    ------
    FrictionloopError
        In one line, naming the column, what was found and what is accepted.
    """
    if not isinstance(recording, xr.Dataset):
        raise must_be("recording", type(recording).__name__, "an xarray.Dataset")
    if name not in recording.data_vars:
        raise no_column(name, recording)
    column = recording[name]
    unit = column.attrs.get("units")
    if unit not in units:
        raise must_be(f"recording: units of {name!r}", unit, " or ".join(map(repr, units)))
    if column.dims != (dim,):
        raise must_be(f"recording: dimensions of {name!r}", column.dims, f"({dim!r},)")
    if column.dtype.kind not in "iuf":
        raise must_be(f"recording: type of {name!r}", str(column.dtype), "numbers")
    values = np.asarray(column.values, dtype=float)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise must_be(f"recording: {name!r} at row {bad[0]}", float(values[bad[0]]), "finite")
    return values


def rate_of(recording: xr.Dataset) -> float:
    """Return the sampling rate in Hz, from ``time`` in s, whose steps must agree within 0.1 %.

    Raises ``FrictionloopError`` for a time that is missing, in another unit, too short or uneven.
    """
    if "time" not in recording.coords:
        raise no_column("time", recording)
    unit = recording["time"].attrs.get("units")
    if unit != "s":
        raise must_be("recording: units of 'time'", unit, "'s'")
    time = np.asarray(recording["time"].values, dtype=float)
    if time.size < 2:
        raise must_be("recording: samples", int(time.size), "at least 2")
    step = (time[-1] - time[0]) / (time.size - 1)
    uneven = np.flatnonzero(~(np.abs(np.diff(time) - step) <= _UNEVEN * abs(step)))
    if not step > 0 or uneven.size:
        row = int(uneven[0]) if uneven.size else 0
        raise must_be(f"recording: step of 'time', row {row}", float(time[row + 1] - time[row]), f"{step:g}", "s")
    # A rate that was a round number comes back as one.
    return float(f"{1 / step:.9g}")


def samples_in(name: str, seconds: float, rate_hz: float, least: int, most: int, why: str) -> int:
    """Return how many samples a time holds, refusing too few and too many; ``why`` says what bounds it."""
    samples = round(seconds * rate_hz) if math.isfinite(seconds) else 0
    if not least <= samples <= most:
        raise must_be(name, float(seconds), f"from {least / rate_hz:g} to {most / rate_hz:g}, {why}", "s")
    return samples


def pieces(found: NDArray[np.bool_], length: int, before: int = 0) -> list[int]:
    """Return the first rows of pieces of this length, each with ``before`` rows ahead of one that is found.

    A piece has room in the recording, and none begins within the one before it.
    """
    starts: list[int] = []
    for row in (np.flatnonzero(found) - before).tolist():
        if row >= 0 and row + length <= found.size and (not starts or row >= starts[-1] + length):
            starts.append(row)
    return starts


def runs_of(found: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return from where to where each run of rows that are found goes."""
    return [(first, last + 1) for first, last in stretches(found)]
