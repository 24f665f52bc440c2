"""Does the loop of a system ring? Linear analysis at the forces asked for, dry and moist, the resonance off or not."""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.analysis.band import operating_band
from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.occlusions import occlusions
from frictionloop.analysis.stability import ringing_hz
from frictionloop.findings import Condition, Finding
from frictionloop.parameters import PiController, Strokes, SuspendedSensor, System
from frictionloop.quantities import FrictionloopError

NEAR = 4.0
"""Ms above which a loop is said to be near instability: less than 0.25 from -1, a phase margin below 15 degrees."""
LARGEST = 2.0
"""Ms that is asked for where nobody asks for another: a phase margin of at least 29 degrees."""


class Rings(NamedTuple):
    """Whether a loop rings."""

    stable: bool | None
    """None where the loop has no linear analysis, as behind a recording whose level is not known."""
    finding: Finding | None = None
    """That it is unstable, or close to it."""


def points_of(system: System) -> list[LinearLoop]:
    """Return the loops looked at: gains of a PI up to full occlusion, another law up to the end of a contact.

    Raises
    ------
    FrictionloopError
        A loop that has no linear analysis.
    """
    plain = isinstance(system.controller, PiController)
    return operating_band(system, occluded=(0.0, 1.0) if plain else occlusions(system))


def ringing(system: System, resonance_off: float = 0.0) -> Rings:
    """Return whether the loop is unstable or its Ms above `NEAR`.

    Parameters
    ----------
    system
        The loop.
    resonance_off
        Share by which the sensor's resonance is off; a sensor without one stays as it is.
    """
    sensor, there = system.sensor, system
    if resonance_off and isinstance(sensor, SuspendedSensor):
        there = system.evolve({"sensor.resonance_hz": (1.0 + resonance_off) * sensor.resonance_hz})
    try:
        points = points_of(there)
        unstable = [each.elements.occluded for each in points if not each.is_stable()]
        peak = math.inf if unstable else max(each.sensitivity_peak() for each in points)
    except FrictionloopError:
        return Rings(None)
    speed = system.motion.speed_mm_s if isinstance(system.motion, Strokes) else None
    where = Condition(
        speed_mm_s=speed, occluded=min(unstable, default=0.0) or None, resonance_off=resonance_off or None
    )
    if unstable:
        return Rings(False, Finding("LOOP-UNSTABLE", value=ringing_hz(points), unit="Hz", where=where))
    return Rings(True, Finding("LOOP-NEAR", value=peak, limit=LARGEST, where=where) if peak > NEAR else None)
