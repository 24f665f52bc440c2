"""How moist a finger gets: the states in which a loop is looked at."""

from __future__ import annotations

import math

from frictionloop.parameters import FingerFriction, Strokes, System
from frictionloop.physics.occlusion import occlusion_after

CONTACT_S = 10.0
"""How long a finger that never lifts is looked at, s: as long as a trial (paper, Sec. 4.2)."""


def occlusions(system: System) -> tuple[float, ...]:
    """Return how far occlusion is looked at, 0 to 1: landed for the first time, and `moistest`."""
    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return (0.0,)
    return 0.0, moistest(friction, motion)


def moistest(friction: FingerFriction, motion: Strokes) -> float:
    """Return the occlusion at the end of many contacts one after another; of a finger that never lifts after 10 s."""
    if motion.contact_s == 0.0:
        return occlusion_after(friction, CONTACT_S, 0.0)
    return occlusion_after(friction, motion.contact_s, motion.lifted_s, math.inf)
