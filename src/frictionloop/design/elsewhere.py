"""Where a controller was looked at: slip lengths and speeds as values, how it does there, and the words for both."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from frictionloop.design.corners import NOTHING, Corner, broken, corners
from frictionloop.design.leaning import Lean
from frictionloop.design.over import ITSELF, Over, at_place
from frictionloop.parameters import Skin, Strokes, System
from frictionloop.quantities import FrictionloopError

FASTER = (1.0, 4.0)
"""Speeds that a design is looked at, over that of its strokes: 20 and 80 mm/s, as in the comparison of laws."""
SLOWER = 0.5
"""Speed over the slowest held that is looked at too: a finger that strokes passes every slower speed (assumed)."""
NEAR = 4.0
"""Ms above which a loop is said to be near instability: less than 0.25 from -1, a phase margin below 15 degrees."""
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
    def speeds(self) -> str:
        """The speed, or the ends of the range, without unit."""
        return " to ".join(f"{each:g}" for each in dict.fromkeys((*self.speeds_mm_s[:1], *self.speeds_mm_s[-1:])))


class Elsewhere(NamedTuple):
    """Slip lengths and speeds that a controller was looked at besides."""

    places: tuple[Place, ...] = ()
    unseen: tuple[str, ...] = ()
    """Those that cannot be looked at, in words with the reason."""

    def where(self, how: How) -> tuple[Place, ...]:
        """Return the places at which the controller does so."""
        return tuple(each for each in self.places if each.how == how)

    def warning(self) -> tuple[str, ...]:
        """Return the lines that come before all others: where the loop is unstable, or nearly so."""
        found = (("UNSTABLE", in_words(self.where("unstable"))), ("CLOSE TO UNSTABLE", in_words(self.where("near"))))
        done = "Do not use it there: it was not designed for it."
        return tuple(f"{what} on {'; on '.join(places)}. {done}" for what, places in found if places)


def in_words(places: Iterable[Place]) -> list[str]:
    """Return places in words, those alike in one, as `alike` has them."""
    return [words for words, _ in alike(places)]


def alike(places: Iterable[Place]) -> list[tuple[str, Place]]:
    """Return groups of places in words, each with its worst: slip length 0 um at 10, 20 mm/s (Ms up to 4.5).

    The error of the resonance and Ms are those of the worst corner, left out where the limits hold.
    """
    groups: dict[tuple[float | None, How, float], list[Place]] = {}
    for each in places:
        off = 0.0 if each.how == "within" else each.worst.off
        groups.setdefault((each.slip_length_um, each.how, off), []).append(each)
    worst = [max(group, key=lambda place: place.worst.excess) for group in groups.values()]
    return [(_said(*key, group), each) for (key, group), each in zip(groups.items(), worst, strict=True)]


def _said(length_um: float | None, how: How, off: float, group: Sequence[Place]) -> str:
    speeds = ", ".join(each.speeds for each in sorted(group, key=lambda each: each.speeds_mm_s) if each.speeds)
    where = ["this loop" if length_um is None else f"slip length {length_um:g} um"]
    where += [f"at {speeds} mm/s"] if speeds else []
    where += [f"with the resonance {100 * abs(off):.3g} % {'higher' if off > 0 else 'lower'}"] if off else []
    peak = max(each.worst.sensitivity_peak for each in group)
    many = "up to " if len(group) > 1 else ""
    return " ".join([*where, *([f"(Ms {many}{peak:.3g})"] if how in ("near", "beyond") else [])])


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
            given = ", ".join(f"{path} = {value}" for path, value in changes.items())
            unseen.append(f"not looked at with {given}: {error}")
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
