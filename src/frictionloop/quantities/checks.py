"""What a formula accepts: one line for every value that is not a number, not finite or out of range."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities.units import FrictionloopError

Array = NDArray[np.float64]
ABOVE_0 = math.ulp(0.0)
"""The least number above 0."""


def as_numbers(name: str, values: Any, unit: str) -> Array:
    """Return values as an array of any numbers, refusing what is none."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise FrictionloopError(f"{name} = {values!r}: must be a number or an array of numbers in {unit}") from None


def numbers(name: str, values: Any, unit: str, least: float = -math.inf, most: float = math.inf) -> Array:
    """Return values as an array, refusing what is no number, not finite or outside least to most."""
    found = as_numbers(name, values, unit)
    wrong = found[~(np.isfinite(found) & (found >= least) & (found <= most))]
    if wrong.size:
        raise FrictionloopError(f"{name} = {wrong[0]:g} {unit}: must be finite{_range(least, most)}")
    return found


def number(name: str, value: Any, unit: str, least: float = -math.inf, most: float = math.inf) -> float:
    """Return one value as a float, refusing the same and whatever is more than one."""
    found = numbers(name, value, unit, least, most)
    if found.size != 1:
        raise FrictionloopError(f"{name} has shape {found.shape}: must be one number in {unit}")
    return float(found.reshape(()))


def _range(least: float, most: float) -> str:
    if math.isfinite(most):
        return f" and from {least:g} to {most:g}"
    if least == ABOVE_0:
        return " and above 0"
    return f" and at least {least:g}" if math.isfinite(least) else ""
