"""What a certificate holds for programs, and two of them over time: what has changed more than its uncertainty."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from scipy.stats import t as student

from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row, Tables
from frictionloop.identification.estimate import Estimate, Measured
from frictionloop.identification.finger_population import TAU, People
from frictionloop.quantities import must_be
from frictionloop.quantities.whole_files import text_of

FINGERS = 1.96
"""So many spreads on either side hold 95 of 100 fingers."""
LOOP = (
    *("sensor.resonance_hz", "sensor.q", "sensor.cutoff_hz", "plate.frequency_hz", "plate.q"),
    *("plate.max_amplitude_um", "controller.delay_s", "friction.nominal_n", TAU, "friction.load_exponent"),
)
"""Measured values on which the loop's margins depend."""

_HELD = re.compile(r'<script type="application/json" id="measured">(.*?)</script>', re.DOTALL)
CERTIFICATE_BYTES = 10**8
ACCEPTED = "a certificate (.html), bench (.json)"
CHANGED = 0.01
"""Chance of so large a difference below which a value is said to have changed (assumed)."""
Dated = tuple[Estimate, str]
"""A value and when it was measured."""


def certified(path: str | os.PathLike[str]) -> Any:
    """Return what a certificate (.html), or the output of ``identify bench --json`` (.json), holds.

    Raises ``FrictionloopError`` for a file that cannot be read or holds nothing of the kind.
    """
    text = text_of(path, CERTIFICATE_BYTES)
    held = _HELD.search(text)
    try:
        return json.loads(held.group(1) if held else text)
    except ValueError:
        raise must_be(str(path), "no measured values", ACCEPTED) from None


def certified_corners(path: str | os.PathLike[str]) -> tuple[Corner, ...]:
    """Return the ends of the intervals that a certificate lists: benches on which gains have to hold.

    Raises ``FrictionloopError`` for a file that cannot be read or lists none.
    """
    tree = certified(path)
    try:
        return tuple(Corner(str(each["path"]), float(each["value"]), str(each["side"])) for each in tree["corners"])
    except (ValueError, KeyError, TypeError):
        raise must_be(str(path), "no corners", ACCEPTED) from None


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

    def finding(self) -> Finding:
        """Return that it has changed."""
        old, new = (0.0 if each is None else each.value for each in (self.before, self.after))
        more = {"path": self.path, "before": old, "after": new, "chance": self.chance}
        return Finding("VALUE-CHANGED", value=100.0 * self.share, unit=self.after.unit if self.after else "", more=more)

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name."""
        return self._asdict() | {"change": self.share, "changed": self.changed}


class Comparison(Result, schema="identify.compare/1"):
    """Two certificates of a bench."""

    before: str
    after: str
    values: tuple[Change, ...]

    def rows(self) -> list[Row]:
        """Return how many values have changed."""
        both = [each for each in self.values if not math.isnan(each.chance)]
        return [("changed", f"{sum(each.changed for each in both)} of {len(both)} values measured twice")]

    def tables(self) -> Tables:
        """Return the values before and after, their change, and its chance where nothing has changed."""
        import pandas as pd  # type: ignore[import-untyped]

        index = [each.path for each in self.values]
        short = {
            "before": [None if each.before is None else each.before.value for each in self.values],
            "after": ["-" if each.after is None else str(each.after._replace(unit="")) for each in self.values],
            "change, %": [100 * each.share for each in self.values],
            "chance": [each.chance for each in self.values],
        }
        whole = {side: [str(getattr(each, side) or "-") for each in self.values] for side in ("before", "after")}
        return {"values": pd.DataFrame(short, index), "intervals": pd.DataFrame(whole, index)}


def compare(before: str | os.PathLike[str], after: str | os.PathLike[str]) -> Comparison:
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
    found = tuple(_change(path, old.get(path), new.get(path)) for path in dict.fromkeys([*old, *new]))
    changed = tuple(each.finding() for each in found if each.changed)
    return Comparison(before=str(before), after=str(after), values=found, findings=changed)


def _change(path: str, old: Dated | None, new: Dated | None) -> Change:
    (one, before), (other, after) = old or (None, ""), new or (None, "")
    if one is None or other is None:
        return Change(path, one, other, (before, after), math.nan)
    a, b = one.standard_error**2, other.standard_error**2
    if a + b == 0:
        return Change(path, one, other, (before, after), 1.0 if one.value == other.value else 0.0)
    below = (a / (a + b)) ** 2 / one.freedom + (b / (a + b)) ** 2 / other.freedom
    freedom = 1 / below if below else math.inf
    apart = abs(other.value - one.value) / math.sqrt(a + b)
    return Change(path, one, other, (before, after), float(2 * student.sf(apart, freedom)))


def _values(path: str | os.PathLike[str]) -> dict[str, Dated]:
    tree = certified(path)
    try:
        listed = map(Measured.from_dict, tree["measured"] if isinstance(tree, dict) else tree)
        return {str(each.path): (each.estimate, str(each.date)) for each in listed}
    except (ValueError, KeyError, TypeError):
        raise must_be(str(path), "no measured values", ACCEPTED) from None


class Corner(NamedTuple):
    """One value at an end of its interval, at which gains have to hold."""

    path: str
    value: float
    side: str
    """"low" or "high"."""


def corners_of(values: Mapping[str, Measured], crowd: People | None) -> tuple[Corner, ...]:
    """Return both ends of the 95 % interval of each measured value that the loop depends on.

    The controller is not told: ``system.evolve({corner.path: corner.value})`` is the bench it has to hold on. The ends
    are value e^(+-half width/value), never below 0. Of what a population tells they hold 95 of 100 fingers, and not the
    median alone.
    """
    spreads = {} if crowd is None else {each.path: FINGERS * each.spread for each in crowd.population.value}
    found = []
    for path in LOOP:
        if path in values:
            each = values[path]
            half = max((each.interval().high - each.value) / each.value, spreads.get(path, 0.0))
            ends = {"low": math.exp(-half), "high": math.exp(half)}
            found += [Corner(path, each.value * factor, side) for side, factor in ends.items()]
    return tuple(found)
