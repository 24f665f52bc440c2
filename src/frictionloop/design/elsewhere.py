"""Where a controller was looked at: slip lengths and speeds, and how it does there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

from frictionloop.analysis import rings
from frictionloop.design.corners import NOTHING, Corner, broken, corners
from frictionloop.design.leaning import Lean
from frictionloop.design.over import ITSELF, Over, at_place
from frictionloop.findings import Condition, Finding
from frictionloop.parameters import Skin, Strokes, System
from frictionloop.quantities import FrictionloopError

FASTER = (1.0, 4.0)
"""Speeds that a design is looked at, over that of its strokes: 20 and 80 mm/s, as in the comparison of laws."""
SLOWER = 0.5
"""Speed over the slowest held that is looked at too: a finger that strokes passes every slower speed (assumed)."""
NEAR = rings.NEAR
"""Ms above which a loop is said to be near instability."""
How = Literal["unstable", "near", "beyond", "within"]
"""How a controller does at a place: Ms above `NEAR` is near, beyond its limit is beyond."""


class Place(NamedTuple):
    """A slip length, and a speed or a range of speeds."""

    slip_length_um: float | None
    """None without a skin."""
    speeds_mm_s: tuple[float, ...]
    """Rising, all held to the same limits; none without strokes."""
    corners: tuple[Corner, ...]

    @classmethod
    def of(cls, found: Sequence[Corner]) -> Place:
        """Return the place of corners at one slip length."""
        systems = [each.loop.system for each in found]
        speeds = {each.motion.speed_mm_s for each in systems if isinstance(each.motion, Strokes)}
        finger = systems[0].finger
        return cls(finger.slip_length_um if isinstance(finger, Skin) else None, tuple(sorted(speeds)), tuple(found))

    @property
    def worst(self) -> Corner:
        """The corner farthest beyond its limit; of unstable ones that with the smallest error of the resonance."""
        rings = [each for each in self.corners if math.isinf(each.sensitivity_peak)]
        if rings:
            return min(rings, key=lambda each: abs(each.off))
        return max(self.corners, key=lambda each: each.excess)

    @property
    def how(self) -> How:
        """How the controller does there."""
        worst = self.worst
        if math.isinf(worst.sensitivity_peak):
            return "unstable"
        if broken(self.corners) is None:
            return "within"
        return "near" if worst.sensitivity_peak > NEAR else "beyond"

    @property
    def condition(self) -> Condition:
        """Where that is."""
        ends = dict.fromkeys((*self.speeds_mm_s[:1], *self.speeds_mm_s[-1:]))
        speed = next(iter(ends), None) if len(ends) < 2 else tuple(ends)
        return Condition(slip_length_um=self.slip_length_um, speed_mm_s=speed)

    def peak_at(self, off: float) -> float:
        """Return the largest Ms with the resonance off by a share."""
        return max(each.sensitivity_peak for each in self.corners if each.off == off)

    def to_dict(self) -> dict[str, Any]:
        """Return it by name."""
        offs = sorted({each.off for each in self.corners})
        peaks = [{"resonance_off": off, "sensitivity_peak": self.peak_at(off)} for off in offs]
        return {**self.condition.values, "how": self.how, "worst": self.worst, "peaks": peaks}


class Elsewhere(NamedTuple):
    """Slip lengths and speeds that a controller was looked at besides."""

    places: tuple[Place, ...] = ()
    unseen: tuple[Finding, ...] = ()
    """Those that cannot be looked at."""


def elsewhere(
    system: System,
    limits: Mapping[float, float],
    over: Over = ITSELF,
    lean: Lean = NOTHING,
    lengths_um: tuple[float, ...] | None = None,
) -> Elsewhere:
    """Return how a System's controller does besides the slip lengths and the speeds at which it has to hold.

    That is at both ends of the lengths, from 0 if none are named, at the speed of its strokes, four times that and
    half of it; with a range of speeds also at its ends. It is pressed with each of the loads.
    """
    places, unseen = [], []
    for changes in strokes_of(system, over.speeds_mm_s, lengths_um):
        try:
            there = at_place(system, changes)
            if not _held(there, system, over):
                places.append(Place.of(corners(there, limits, Over(loads_n=over.loads_n), lean)))
        except FrictionloopError as error:  # no such stroke, a force out of reach, a law that is saturated there
            where = Condition(**{path.split(".")[1]: value for path, value in changes.items()})
            unseen.append(Finding("PLACE-UNSEEN", where=where, more={"reason": str(error)}))
    return Elsewhere(tuple(places), tuple(unseen))


def strokes_of(
    system: System, speeds_mm_s: Sequence[float] = (), lengths_um: tuple[float, ...] | None = None
) -> list[dict[str, Any]]:
    """Return overrides for the slip lengths and speeds that are looked at, the longest first.

    None without a skin; no slower speed at which the controller would hold its output.
    """
    if not isinstance(system.finger, Skin):
        return []
    lengths, motion = Over(lengths_um).lengths_of(system), system.motion
    if not isinstance(motion, Strokes):
        return [{"finger.slip_length_um": z} for z in lengths]
    usual = motion.speed_mm_s
    speeds = {usual * faster for faster in FASTER} | ({min(speeds_mm_s), max(speeds_mm_s)} if speeds_mm_s else set())
    slowest = SLOWER * min(speeds_mm_s, default=usual)
    speeds |= {slowest} if slowest >= system.touch.load.least_speed_mm_s else set()
    return [{"finger.slip_length_um": z, "motion.speed_mm_s": v} for z in lengths for v in sorted(speeds)]


def _held(there: System, system: System, over: Over) -> bool:
    """Tell whether a place has a slip length and a speed at which the controller of a system was held."""
    if isinstance(there.finger, Skin) and there.finger.slip_length_um not in over.lengths_of(system):
        return False
    if not (isinstance(there.motion, Strokes) and isinstance(system.motion, Strokes)):
        return True
    speeds = over.speeds_mm_s or (system.motion.speed_mm_s,)
    return min(speeds) <= there.motion.speed_mm_s <= max(speeds)
