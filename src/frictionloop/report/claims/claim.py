"""A claim of the paper as data: what is printed, what comes out here, what counts as agreement, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, TypeVar

from frictionloop.report.device import RETUNED_GAINS

T = TypeVar("T")
Value = float | None
"""A computed number; None where what was looked for does not exist."""


class Verdict(StrEnum):
    """What the numbers say about a claim."""

    REPRODUCED = "reproduced"
    """Every reading of the text gives an accepted number."""
    NOT_REPRODUCED = "not reproduced"
    """No reading does, nor do the re-tuned gains."""
    READING_DEPENDENT = "reading-dependent"
    """Some readings do."""
    OTHER_GAINS = "only with other gains"
    """No reading does, but the re-tuned gains do in at least one way of counting."""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One statement of the paper beside the number computed for it."""

    id: str
    title: str
    """The statement in a few words."""
    place: str
    """Section and figure of the paper."""
    quote: str
    """The words printed."""
    published: float | str
    """The number printed, or the word where there is none."""
    unit: str = ""
    measure: str
    """What the number is, where title and unit do not say."""
    readings: Mapping[str, Value]
    """The computed number under each reading of the text; the working reading is first. Only these decide."""
    accepted: tuple[float, float]
    """Numbers that agree with the claim, both ends included: set by a rule, never by the result."""
    tolerance: str
    """Where ``accepted`` comes from."""
    explanation: str
    command: str
    """A command line that prints ``ours``."""
    compared: Mapping[str, Value] = field(default_factory=dict)
    """The number for what the text does not say: other gains, an ideal sensor, a reachable set-point."""
    digits: int = 3
    """Digits of the numbers where they are shown."""

    @property
    def ours(self) -> Value:
        """The number under the working reading."""
        return next(iter(self.readings.values()))

    @property
    def holds(self) -> dict[str, bool]:
        """Whether each reading's number is accepted."""
        return {name: self._accepts(value) for name, value in self.readings.items()}

    @property
    def compared_holds(self) -> dict[str, bool]:
        """Whether the number of each comparison is accepted."""
        return {name: self._accepts(value) for name, value in self.compared.items()}

    def _accepts(self, value: Value) -> bool:
        low, high = self.accepted
        return value is not None and low <= value <= high

    @property
    def verdict(self) -> Verdict:
        """What the readings decide; comparisons only tell "not reproduced" from "only with other gains"."""
        held = self.holds.values()
        if all(held):
            return Verdict.REPRODUCED
        if any(held):
            return Verdict.READING_DEPENDENT
        retuned = having(self.compared_holds, [RETUNED_GAINS])
        return Verdict.OTHER_GAINS if any(retuned.values()) else Verdict.NOT_REPRODUCED

    def as_dict(self) -> dict[str, Any]:
        """Return the claim for JSON: an end of ``accepted`` that is infinite becomes null."""
        return {
            "id": self.id,
            "title": self.title,
            "place": self.place,
            "quote": self.quote,
            "published": self.published,
            "ours": self.ours,
            "unit": self.unit,
            "measure": self.measure,
            "readings": dict(self.readings),
            "compared": dict(self.compared),
            "tolerance": {"accepted": [_finite(end) for end in self.accepted], "from": self.tolerance},
            "verdict": str(self.verdict),
            "explanation": self.explanation,
            "command": self.command,
        }


def having(values: Mapping[str, T], names: Collection[str]) -> dict[str, T]:
    """Return the entries of which one part of the name, between commas, is one of ``names``."""
    return {name: value for name, value in values.items() if not set(names).isdisjoint(name.split(", "))}


def lacking(values: Mapping[str, T], names: Collection[str]) -> dict[str, T]:
    """Return the other entries."""
    kept = having(values, names)
    return {name: value for name, value in values.items() if name not in kept}


def _finite(value: float) -> Value:
    return value if math.isfinite(value) else None


def python(code: str) -> str:
    """Return the command line that runs Python code; the code holds no double quotes."""
    return f'python -c "{code}"'
