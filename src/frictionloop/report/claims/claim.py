"""A claim of the paper as data: what is printed, what comes out here, what counts as agreement, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

Value = float | None
"""A computed number; None where what was looked for does not exist."""


class Verdict(StrEnum):
    """What the numbers say about a claim."""

    REPRODUCED = "reproduced"
    """Every reading gives an accepted number."""
    NOT_REPRODUCED = "not reproduced"
    """No reading does."""
    READING_DEPENDENT = "reading-dependent"
    """Some do."""


@dataclass(frozen=True)
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
    unit: str
    measure: str
    """What the number is, where title and unit do not say."""
    readings: Mapping[str, Value]
    """The computed number under each reading of the text; the working reading is first."""
    accepted: tuple[float, float]
    """Numbers that agree with the claim, both ends included: set by a rule, never by the result."""
    tolerance: str
    """Where ``accepted`` comes from."""
    explanation: str
    command: str
    """A command line that prints ``ours``."""

    @property
    def ours(self) -> Value:
        """The number under the working reading."""
        return next(iter(self.readings.values()))

    @property
    def holds(self) -> dict[str, bool]:
        """Whether each reading's number is accepted."""
        low, high = self.accepted
        return {name: value is not None and low <= value <= high for name, value in self.readings.items()}

    @property
    def verdict(self) -> Verdict:
        """Reproduced if every reading holds, not reproduced if none does, else reading-dependent."""
        held = self.holds.values()
        if all(held):
            return Verdict.REPRODUCED
        return Verdict.READING_DEPENDENT if any(held) else Verdict.NOT_REPRODUCED

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
            "tolerance": {"accepted": [_finite(end) for end in self.accepted], "from": self.tolerance},
            "verdict": str(self.verdict),
            "explanation": self.explanation,
            "command": self.command,
        }


def _finite(value: float) -> Value:
    return value if math.isfinite(value) else None


def python(code: str) -> str:
    """Return the command line that runs Python code; the code holds no double quotes."""
    return f'python -c "{code}"'
