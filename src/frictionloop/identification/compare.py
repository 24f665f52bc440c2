"""Two certificates of a bench, over time: what has changed more than its uncertainty."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any, NamedTuple

from scipy.stats import t as student

from frictionloop.identification.certified import ACCEPTED, certified
from frictionloop.identification.estimate import Estimate
from frictionloop.quantities import FrictionloopError

CHANGED = 0.01
"""Chance of so large a difference below which a value is said to have changed (assumed)."""


class Change(NamedTuple):
    """One value in two certificates."""

    path: str
    before: Estimate | None
    """None: not measured then."""
    after: Estimate | None
    dates: tuple[str, str]
    chance: float
    """Of a difference so large if nothing has changed; NaN where one is missing."""

    @property
    def changed(self) -> bool:
        """Whether the value has changed beyond its uncertainty."""
        return self.chance < CHANGED

    @property
    def share(self) -> float:
        """Relative change; NaN where one is missing."""
        if self.before is None or self.after is None or self.before.value == 0:
            return math.nan
        return self.after.value / self.before.value - 1


def compare(before: str | os.PathLike[str], after: str | os.PathLike[str]) -> list[Change]:
    """Return each measured value of two certificates, with Welch's test of their difference.

        t = (b - a) / sqrt(s_a^2 + s_b^2),   1/freedom = sum of (share of the variance)^2 / freedom

    Parameters
    ----------
    before, after : path
        Certificates (.html), or what ``identify bench --json`` printed (.json).

    Raises
    ------
    FrictionloopError
        For a file that cannot be read or holds no measured values.
    """
    old, new = _values(before), _values(after)
    return [_change(path, old.get(path), new.get(path)) for path in dict.fromkeys([*old, *new])]


def _change(path: str, old: Mapping[str, Any] | None, new: Mapping[str, Any] | None) -> Change:
    one, other = (None if each is None else _estimate(each) for each in (old, new))
    dates = ("" if old is None else str(old["date"]), "" if new is None else str(new["date"]))
    if one is None or other is None:
        return Change(path, one, other, dates, math.nan)
    a, b = one.standard_error**2, other.standard_error**2
    if a + b == 0:
        return Change(path, one, other, dates, 1.0 if one.value == other.value else 0.0)
    below = (a / (a + b)) ** 2 / one.freedom + (b / (a + b)) ** 2 / other.freedom
    freedom = 1 / below if below else math.inf
    apart = abs(other.value - one.value) / math.sqrt(a + b)
    return Change(path, one, other, dates, float(2 * student.sf(apart, freedom)))


def _estimate(each: Mapping[str, Any]) -> Estimate:
    error = math.sqrt(sum(float(each[line]) ** 2 for line in ("within", "between", "method")))
    freedom = math.inf if each["freedom"] is None else float(each["freedom"])
    return Estimate(float(each["value"]), error, str(each["unit"]), freedom)


def _values(path: str | os.PathLike[str]) -> dict[str, Mapping[str, Any]]:
    tree = certified(path)
    try:
        measured = tree["measured"] if isinstance(tree, dict) else tree
        values = {str(each["path"]): each for each in measured}
        for each in values.values():
            _estimate(each)
            str(each["date"])
        return values
    except (ValueError, KeyError, TypeError):
        raise FrictionloopError(f"{path}: holds no measured values; {ACCEPTED}") from None
