"""The corners at which a designed controller has to hold: forces, a dry and a moist finger, resonances a little off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from frictionloop.analysis.band import operating_band
from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.margins import Margins
from frictionloop.analysis.state_space import StateSpace
from frictionloop.design.detuned import detuned
from frictionloop.design.learnt import conditions, knowing
from frictionloop.parameters import FingerFriction, Skin, Strokes, SuspendedSensor, System

CONTACT_S = 10.0
"""How long a finger that never lifts is looked at, s: as long as a trial (paper, Sec. 4.2)."""
MET = 1e-3
"""Share by which Ms may be beyond a limit: the accuracy of the searches."""


class Corner(NamedTuple):
    """One loop, and the margins that it has."""

    off: float
    """Share by which the resonance is off."""
    loop: LinearLoop
    margins: Margins

    @property
    def where(self) -> str:
        """Where that is, in words."""
        found = self.loop.elements
        off = f", resonance {self.off:+.0%} off" if self.off else ""
        return f"{found.force_n:.3g} N, {'moist' if found.occluded > 0 else 'dry'} finger{self.stroke}{off}"

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


def band_of(system: System) -> list[LinearLoop]:
    """Return the loops at lowest, mean and highest force asked for, on a dry and on a moist finger."""
    return operating_band(system, occluded=occlusions(system))


def with_shifts(system: System, limits: Mapping[float, float]) -> list[tuple[LinearLoop, float, float]]:
    """Return the loops of `band_of` with the resonance off either way by what the limits name, and the limit on Ms.

    Returns
    -------
    list of (LinearLoop, float, float)
        Loop, share by which its resonance is off, largest Ms.
    """
    points = band_of(system)
    sprung = isinstance(system.sensor, SuspendedSensor)
    shifts = [(sign * e, peak) for e, peak in limits.items() for sign in ((-1.0, 1.0) if e else (0.0,))]
    return [
        (detuned(point, 1.0 + off) if off else point, off, peak)
        for off, peak in sorted(shifts)
        if sprung or not off
        for point in points
    ]


def stroke_of(system: System) -> str:
    """Return on which contact and at which speed a loop is linearised, for a person; empty for neither."""
    finger, motion = system.finger, system.motion
    contact = f", contact {finger.contact}" if isinstance(finger, Skin) else ""
    return contact + (f", {motion.speed_mm_s:g} mm/s" if isinstance(motion, Strokes) else "")


def at_mean(system: System, off: float = 0.0) -> LinearLoop:
    """Return the loop at the mean force on a dry finger, the resonance off by a share."""
    loop = linearise(knowing(system))
    return detuned(loop, 1.0 + off) if off else loop


def corners(system: System, limits: Mapping[float, float]) -> list[Corner]:
    """Return the margins of a System's controller at the loops of `with_shifts`, under all its `conditions`.

    Raises
    ------
    FrictionloopError
        A law that has no linear analysis at one of them.
    """
    return [each for there in conditions(system) for each in _under(there, limits)]


def _under(system: System, limits: Mapping[float, float]) -> list[Corner]:
    """Return the corners of one contact and speed; a law does not change with the springs, so it is made once."""
    laws: dict[tuple[float, float], StateSpace] = {}
    found = []
    for loop, off, _ in with_shifts(system, limits):
        at = (loop.elements.force_n, loop.elements.occluded)
        if at not in laws:
            laws[at] = loop.law
        there = replace(loop, known_law=laws[at])
        found.append(Corner(off, there, there.margins()))
    return found


def broken(found: Sequence[Corner], limits: Mapping[float, float]) -> Corner | None:
    """Return the corner farthest beyond its limit, None if all hold."""
    by_off = {round(sign * error, 9): peak for error, peak in limits.items() for sign in (-1, 1)}

    def excess(each: Corner) -> float:
        return each.margins.sensitivity_peak / by_off[round(each.off, 9)]

    worst = max(found, key=excess)
    return worst if excess(worst) > 1.0 + MET else None
