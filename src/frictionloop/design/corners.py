"""The corners at which a controller has to hold: forces, dry and moist, resonances; other contacts and speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from frictionloop.analysis.band import operating_band
from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.margins import Margins
from frictionloop.analysis.state_space import StateSpace
from frictionloop.design.leaning import Lean, leaning
from frictionloop.design.plants import detuned, shifted
from frictionloop.parameters import FingerFriction, Skin, Strokes, System
from frictionloop.quantities import FrictionloopError

CONTACTS = ("dahl", "slider")
FASTER = (1.0, 4.0)
"""Speeds that a design is looked at, over that of its strokes: 20 and 80 mm/s, as in the comparison of laws."""
SLOWER = 0.5
"""Speed over the slowest held that is looked at too: a finger that strokes passes every slower speed (assumed)."""
CONTACT_S = 10.0
"""How long a finger that never lifts is looked at, s: as long as a trial (paper, Sec. 4.2)."""
MET = 1e-3
"""Share by which Ms may be beyond a limit: the accuracy of the searches."""
NOTHING = Lean()
NEAR = 4.0
"""Ms above which a loop is said to be near instability: less than 0.25 from -1, a phase margin below 15 degrees."""


class Corner(NamedTuple):
    """One loop, and how near it comes to instability."""

    off: float
    """Share by which the resonance is off."""
    limit: float
    """Largest Ms there."""
    loop: LinearLoop
    sensitivity_peak: float
    """Ms, infinite if the loop is unstable."""

    @property
    def margins(self) -> Margins:
        """All margins of the loop, which take longer to find."""
        return self.loop.margins()

    @property
    def where(self) -> str:
        """Where that is, in words."""
        found = self.loop.elements
        off = f", resonance {self.off:+.0%} off" if self.off else ""
        return f"{found.force_n:.3g} N, {'moist' if found.occluded > 0 else 'dry'} finger{self.stroke}{off}"

    @property
    def excess(self) -> float:
        """Return Ms over the largest one."""
        return self.sensitivity_peak / self.limit

    @property
    def stroke(self) -> str:
        """Contact and speed, in words."""
        return stroke_of(self.loop.system)


def occlusions(system: System) -> tuple[float, ...]:
    """Return how far occlusion is looked at, 0 to 1: just landed, and at the end of a contact."""
    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return (0.0,)
    return 0.0, -math.expm1(-(motion.contact_s or CONTACT_S) / friction.occlusion_s)


def band_of(system: System, speeds_mm_s: Sequence[float] = ()) -> list[LinearLoop]:
    """Return the loops at lowest, mean and highest force asked for, on a dry and on a moist finger, at each speed."""
    if not speeds_mm_s:
        return operating_band(system, occluded=occlusions(system))
    if not isinstance(system.motion, Strokes):
        raise FrictionloopError(f'speeds_mm_s: motion.kind = "{system.motion.kind}" has none; needs "strokes"')
    return [loop for speed in speeds_mm_s for loop in band_of(system.evolve({"motion.speed_mm_s": speed}))]


def stroke_of(system: System) -> str:
    """Return on which contact and at which speed a loop is linearised, for a person; empty for neither."""
    finger, motion = system.finger, system.motion
    contact = f", contact {finger.contact}" if isinstance(finger, Skin) else ""
    return contact + (f", {motion.speed_mm_s:g} mm/s" if isinstance(motion, Strokes) else "")


def at_mean(system: System, off: float = 0.0) -> LinearLoop:
    """Return the loop at the mean force on a dry finger, the resonance off by a share."""
    loop = linearise(system)
    return detuned(loop, 1.0 + off) if off else loop


def corners(
    system: System, limits: Mapping[float, float], speeds_mm_s: Sequence[float] = (), lean: Lean = NOTHING
) -> list[Corner]:
    """Return Ms of a System's controller at its `band_of`, the resonance off too.

    Sensor, delay, gain and other values are off as well by what ``lean`` says (`leaning`). A law does not change with
    any of this, so it is made once per speed, force and finger.

    Raises
    ------
    FrictionloopError
        A law that has no linear analysis there.
    """
    laws: dict[tuple[str, float, float], StateSpace] = {}
    found = []
    for loop, off, limit in shifted(leaning(band_of(system, speeds_mm_s), lean), limits):
        at = (stroke_of(loop.system), loop.elements.force_n, loop.elements.occluded)
        if at not in laws:
            laws[at] = loop.law
        there = replace(loop, known_law=laws[at])
        found.append(Corner(off, limit, there, there.sensitivity_peak()))
    return found


def broken(found: Sequence[Corner]) -> Corner | None:
    """Return the corner farthest beyond its limit, None if all hold."""
    worst = max(found, key=lambda each: each.excess)
    return worst if worst.excess > 1.0 + MET else None


def strokes_of(system: System) -> list[dict[str, Any]]:
    """Return overrides for both contacts, at the speed of a system and at four times that; none without a skin."""
    if not isinstance(system.finger, Skin):
        return []
    contacts = dict.fromkeys((system.finger.contact, *CONTACTS))
    own = system.motion.speed_mm_s if isinstance(system.motion, Strokes) else None
    speeds = [{}] if own is None else [{"motion.speed_mm_s": own * faster} for faster in FASTER]
    return [{"finger.contact": contact, **speed} for contact in contacts for speed in speeds]


class Elsewhere(NamedTuple):
    """Where a controller does not hold, in words; nothing where it does."""

    unstable: tuple[str, ...] = ()
    """Contacts and speeds at which a loop is unstable, and from which error of the resonance on."""
    near: tuple[str, ...] = ()
    """Those at which it is stable, and so little that Ms is above `NEAR`."""
    beyond: tuple[str, ...] = ()
    """Others at which Ms is beyond its limit."""
    unseen: tuple[str, ...] = ()
    """Those that cannot be looked at, with the reason."""
    within: tuple[str, ...] = ()
    """Those at which the limits hold as well."""

    def warning(self) -> tuple[str, ...]:
        """Return the lines that come before all others."""
        found = (("UNSTABLE", self.unstable), ("CLOSE TO UNSTABLE", self.near))
        said = "Do not use it there: it was not designed for it."
        return tuple(f"{what} {'; '.join(places)}. {said}" for what, places in found if places)

    def notes(self) -> tuple[str, ...]:
        """Return what else is worth a line but where the limits hold, which the verdict says."""
        beyond = (f"beyond its limits elsewhere: {'; '.join(self.beyond)}",) if self.beyond else ()
        return (*beyond, *self.unseen)


def elsewhere(system: System, limits: Mapping[float, float], speeds_mm_s: Sequence[float] = ()) -> Elsewhere:
    """Return where else a System's controller is beyond its limits on Ms, or cannot be looked at.

    Elsewhere are the other contact, four times the speed, and half of it: outside the speeds at which it holds. The
    other contact is looked at with the slowest and the fastest of these as well.
    """
    unstable, near, beyond, unseen, within = [], [], [], [], []
    for changes in [*strokes_of(system), *_ends(system, speeds_mm_s), *_slower(system, speeds_mm_s)]:
        try:
            there = system.evolve(changes)
            found = [] if _held(there, system, speeds_mm_s) else corners(there, limits)
        except FrictionloopError as error:  # no such stroke, a force out of reach, a law that is saturated there
            given = ", ".join(f"{path} = {value}" for path, value in changes.items())
            unseen.append(f"not looked at with {given}: {error}")
            continue
        rings = [each for each in found if math.isinf(each.sensitivity_peak)]
        if rings:
            unstable.append(_place(there, min(rings, key=lambda each: abs(each.off))))
        elif found and (worst := broken(found)):
            place, peak = _place(there, worst), f"Ms {worst.sensitivity_peak:.3g}"
            if worst.sensitivity_peak > NEAR:
                near.append(f"{place} ({peak})")
            else:
                beyond.append(f"{peak} {place}")
        elif found:
            within.append(_place(there))
    return Elsewhere(tuple(unstable), tuple(near), tuple(beyond), tuple(unseen), tuple(within))


def _ends(system: System, speeds_mm_s: Sequence[float]) -> list[dict[str, Any]]:
    """Return overrides for the contact that a skin has not, at the ends of the speeds; none without speeds."""
    if not (speeds_mm_s and isinstance(system.finger, Skin) and isinstance(system.motion, Strokes)):
        return []
    ends = {min(speeds_mm_s), max(speeds_mm_s)} - {system.motion.speed_mm_s * faster for faster in FASTER}
    others = [contact for contact in CONTACTS if contact != system.finger.contact]
    return [{"finger.contact": contact, "motion.speed_mm_s": speed} for contact in others for speed in sorted(ends)]


def _slower(system: System, speeds_mm_s: Sequence[float]) -> list[dict[str, Any]]:
    """Return overrides for a slower stroke of a skin; none for one at which the controller would hold its output."""
    if not (isinstance(system.finger, Skin) and isinstance(system.motion, Strokes)):
        return []
    slowest = SLOWER * min(speeds_mm_s, default=system.motion.speed_mm_s)
    return [{"motion.speed_mm_s": slowest}] if slowest >= system.touch.load.least_speed_mm_s else []


def _held(there: System, system: System, speeds_mm_s: Sequence[float]) -> bool:
    """Tell whether a place differs from a system in nothing but a speed at which its controller was held."""
    if not (speeds_mm_s and isinstance(there.motion, Strokes) and isinstance(system.motion, Strokes)):
        return there == system
    speed = there.motion.speed_mm_s
    alike = there == system.evolve({"motion.speed_mm_s": speed})
    return alike and min(speeds_mm_s) <= speed <= max(speeds_mm_s)


def _place(system: System, corner: Corner | None = None) -> str:
    """Return contact, speed and resonance of a corner, as in "on a slider at 80 mm/s, the resonance 10 % lower"."""
    finger, motion = system.finger, system.motion
    contact = f"on contact {finger.contact}" if isinstance(finger, Skin) else ""
    speed = f" at {motion.speed_mm_s:g} mm/s" if isinstance(motion, Strokes) else ""
    share = 0.0 if corner is None else corner.off
    off = f" with the resonance {100 * abs(share):.3g} % {'higher' if share > 0 else 'lower'}" if share else ""
    return contact + speed + off
