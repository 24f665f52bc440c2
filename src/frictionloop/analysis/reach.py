"""Which of the forces that the signals of a system ask for are out of reach, for a finger that strokes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from frictionloop.analysis.operating import asked, law_at, reach_n
from frictionloop.parameters import System

ROUNDING = 1e-9
"""Share by which a force may be beyond the reach and counts as within: rounding of the steps between."""


class Missed(NamedTuple):
    """A force asked for that is out of reach, and the nearest within."""

    force_n: float
    instead_n: float
    occluded: float
    """State of the finger, 0 (just landed) to 1 (after long contact)."""

    @property
    def short_n(self) -> float:
        """How far the nearest is from what is asked for, N."""
        return abs(self.force_n - self.instead_n)

    @property
    def in_words(self) -> tuple[str, str]:
        """Both forces without unit, with as many digits as tell them apart, three at least."""
        pairs = [(f"{self.force_n:.{digits}g}", f"{self.instead_n:.{digits}g}") for digits in range(3, 12)]
        return next((pair for pair in pairs if pair[0] != pair[1]), pairs[-1])


def missed(system: System, states: Sequence[float] = (0.0,)) -> list[Missed]:
    """Return which of lowest, mean and highest force of set-point less disturbance are out of reach, by state."""
    found = []
    for state in states:
        low, high = reach_n(system, law_at(system, state))
        for force in dict.fromkeys(asked(system)):
            instead = min(max(force, low), high)
            if abs(force - instead) > ROUNDING * max(abs(force), high):
                found.append(Missed(force, instead, state))
    return found
