"""What is accepted: one line for every value out of range, and for every name that is not there."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from frictionloop.quantities.lti import Array
from frictionloop.quantities.units import FrictionloopError

ABOVE_0 = math.ulp(0.0)
"""The least number above 0."""
BELOW_1 = math.nextafter(1.0, 0.0)
"""The greatest number below 1."""


def as_numbers(name: str, values: Any, unit: str) -> Array:
    """Return values as an array of any numbers, refusing what is none."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise FrictionloopError(f"{name} = {values!r}: must be a number or an array of numbers in {unit}") from None


def numbers(
    name: str, values: Any, unit: str, least: float = -math.inf, most: float = math.inf, why: str = ""
) -> Array:
    """Return values as an array, refusing what is no number, not finite or outside least to most (``why`` says so)."""
    found = as_numbers(name, values, unit)
    wrong = found[~(np.isfinite(found) & (found >= least) & (found <= most))]
    if wrong.size:
        given = f"{wrong[0]:g} {unit}".rstrip()
        raise FrictionloopError(f"{name} = {given}: must be finite{_range(least, most)}{why}")
    return found


def number(name: str, value: Any, unit: str, least: float = -math.inf, most: float = math.inf, why: str = "") -> float:
    """Return one value as a float, refusing the same and whatever is more than one."""
    given = as_numbers(name, value, unit)
    if given.size != 1:
        raise FrictionloopError(f"{name} has shape {given.shape}: must be one number{unit and f' in {unit}'}")
    return float(numbers(name, given, unit, least, most, why).reshape(()))


def whole(name: str, value: Any, least: int, most: float = math.inf) -> int:
    """Return a whole number, refusing what is none (a bool is none) or outside least to most."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not least <= value <= most:
        within = f", at least {least}" if most == math.inf else f" from {least} to {most}"
        raise FrictionloopError(f"{name} = {value!r}: must be a whole number{within}")
    return int(value)


def _range(least: float, most: float) -> str:
    if math.isfinite(most):
        return f" and from {least:g} to {'below 1' if most == BELOW_1 else f'{most:g}'}"
    if least == ABOVE_0:
        return " and above 0"
    return f" and at least {least:g}" if math.isfinite(least) else ""


def check_known(option: str, names: Iterable[str], there: Iterable[str]) -> None:
    """Refuse a name that is none of those there are, with near ones."""
    known = list(there)
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=3, cutoff=0.4)
            hint = f"; did you mean {' or '.join(near)}?" if near else ";"
            raise FrictionloopError(f"{option}: {name!r} is unknown{hint} accepted: {', '.join(known)}")


def check_each_once(option: str, what: str, names: Sequence[str]) -> None:
    """Refuse no name at all, or one given twice; ``what`` they name is in the line."""
    if not names or len(set(names)) < len(names):
        raise FrictionloopError(f"{option} = {','.join(names)!r}: {what} names, each once")
