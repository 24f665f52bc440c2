"""Which of the forces that the signals of a system ask for are out of reach, for a finger that strokes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from frictionloop.analysis.operating import asked, law_at, reach_n
from frictionloop.parameters import Strokes, System
from frictionloop.quantities import FrictionloopError

ROUNDING = 1e-9
"""Share by which a force may be beyond the reach and counts as within: rounding of the steps between."""


class Missed(NamedTuple):
    """A force asked for that is out of reach, and the nearest within."""

    force_n: float
    instead_n: float
    occluded: float
    """State of the finger, 0 (just landed) to 1 (after long contact)."""

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


def check_band(system: System, states: Sequence[float] = (0.0,)) -> None:
    """Refuse a band of which an end is out of reach of a finger that has just landed.

    There a loop stays clamped, and a law that knows its clamp has no linear analysis. Only of a finger that strokes:
    the loop of Section 2 asks for more than can be had on purpose.
    """
    if not isinstance(system.motion, Strokes):
        return
    beyond = missed(system, states[:1])
    if beyond:
        raise FrictionloopError(_refusal(system, beyond[0], states))


def _refusal(system: System, beyond: Missed, states: Sequence[float]) -> str:
    reaches = [reach_n(system, law_at(system, state)) for state in states]
    wanted, low = asked(system), beyond.force_n < beyond.instead_n
    most_um = min(system.plate.max_amplitude_um, system.controller.model.max_amplitude_um)
    has = f"{most_um:g} um leave at least" if low else "without vibration there is at most"
    ends = [each[0] if low else each[1] for each in reaches]
    there = ", ".join(f"{end:.3g} N {_state(state)}" for end, state in zip(ends, states, strict=True))
    lows, highs = zip(*reaches, strict=True)
    within = "ask for another force"
    for least, most in ((max(lows), min(highs)), (max(wanted.low_n, *lows), min(wanted.high_n, *highs))):
        lowest, highest = math.ceil(100 * least - ROUNDING) / 100, math.floor(100 * most + ROUNDING) / 100
        within = f"ask for {lowest:g} to {highest:g} N" if lowest < highest else within
    larger = ", or give a larger max_amplitude_um to plate and controller.model" if low else ""
    return f"setpoint less disturbance: {beyond.force_n:.3g} N is out of reach: {has} {there}; {within}{larger}"


def _state(occluded: float) -> str:
    return f"occluded {occluded:.0%}" if occluded > 0 else "just landed"
