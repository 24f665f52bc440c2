"""Arrays and variables of xarray as forces: their numbers in N, and the rate that the times of a variable tell."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np

from frictionloop.quantities.steps import uneven_in
from frictionloop.quantities.units import UNITS, known_unit

SLOWEST_S = 0.5
"""Steps of times without a unit from which on they may count, or be in ms (assumed: no force is recorded so slowly)."""
EVEN = 1e-3
"""Deviation of a step of time from the usual one that counts as none, and of two rates that are one, as a share."""


def in_newtons(values: Any) -> Any:
    """Return an array as a list, in N if it says that it is in a unit of force; other things as they are."""
    array = getattr(values, "values", values)
    if not isinstance(array, np.ndarray):
        return values
    unit = getattr(values, "attrs", {}).get("units", "N")
    of, factor = UNITS.get(known_unit(str(unit)) or "", ("", 1.0))
    if of != "N":
        raise ValueError(f"in {unit}: accepted N, mN, cN, uN, kN, gf, kgf, lbf")
    if array.ndim != 1 or array.dtype.kind not in "iuf":
        over = f" over {', '.join(map(repr, values.dims))}" if hasattr(values, "dims") else ""
        raise ValueError(f"{array.dtype} of shape {array.shape}{over}: needs numbers, one dimension")
    return (factor * array).tolist()


def with_rate(values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the values of ``Samples`` with the rate that the times of a variable tell; others as they are.

    Raises
    ------
    ValueError
        Times that are missing, uneven, of an unknown unit, or contradict a rate that is given.
    """
    array: Any = values.get("values_n")
    given_hz: Any = values.get("rate_hz")
    known = isinstance(given_hz, Real) and float(given_hz) > 0
    if not hasattr(array, "coords") or len(array.dims) != 1:  # of more dimensions `in_newtons` tells
        return values
    if given_hz is not None and (not known or array.dims[0] not in array.coords):
        return values
    rate_hz = _rate_of(array, given_hz)
    if known and abs(given_hz - rate_hz) > EVEN * rate_hz:
        raise ValueError(f"rate_hz = {given_hz:g}: the array's own is {rate_hz:g}")
    return {**values, "rate_hz": rate_hz}


def _rate_of(array: Any, given_hz: Any) -> float:
    """Return the rate in Hz of the times of a variable over one dimension."""
    (dimension,) = array.dims
    if dimension != "time":
        raise ValueError(f"an array over {dimension!r}: must be over 'time'")
    if "time" not in array.coords:
        raise ValueError("an array over 'time' without times: array.assign_coords(time=times_s)")
    time_s = _seconds(array.coords["time"], given_hz)
    if time_s.size < 2:
        raise ValueError("an array of less than two samples")
    usual_s = float(np.median(np.diff(time_s)))
    uneven = uneven_in(time_s, abs(usual_s) or 1.0, EVEN)
    if uneven is not None:
        said = uneven.said(lambda row: f"index {row}: {time_s[row]:g} s")
        raise ValueError(f"{said}; accepted: even steps (most are {usual_s:.4g} s)")
    return float(f"{(time_s.size - 1) / (time_s[-1] - time_s[0]):.9g}")


def _seconds(time: Any, given_hz: Any) -> np.ndarray:
    """Return times of any kind that xarray has in s; a rate that is given settles what they count."""
    times = np.asarray(time)
    if times.dtype.kind in "mM":
        return np.asarray((times - times[:1]) / np.timedelta64(1, "s"), dtype=float)
    if times.dtype.kind not in "iuf":
        raise ValueError(f"times are {times.dtype}: accepted numbers, datetime64, timedelta64")
    said = time.attrs.get("units")
    of, factor = UNITS.get(known_unit(str(said or "s")) or "", ("", 1.0))
    if of != "s":
        raise ValueError(f"times in {said}: accepted s, ms, us, ns, min")
    step = float(np.median(np.diff(times))) if times.size > 1 else 0.0
    if said is None and step >= SLOWEST_S:
        if given_hz is not None:
            return np.asarray(times / step / given_hz, dtype=float)
        raise ValueError(f'times rise by {step:.6g} without a unit: array.time.attrs["units"]')
    return factor * np.asarray(times, dtype=float)
