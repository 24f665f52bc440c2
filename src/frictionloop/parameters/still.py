"""What a finger that strokes varies by itself, and the values under which it does not."""

from __future__ import annotations

from operator import attrgetter

from frictionloop.parameters.finger import FingerFriction
from frictionloop.parameters.motion import Strokes
from frictionloop.parameters.system import System

STILL = {
    "motion.tremor_um": 0.0,
    "motion.tremor_n": 0.0,
    "motion.load_drift": 0.0,
    "friction.roughness_rms": 0.0,
    "friction.occlusion_ratio": 1.0,
    "friction.moist_loss": 0.0,
}
"""Values with which a finger has no variation of its own: no tremor, drift of load, roughness, moisture."""


def stirring(system: System) -> dict[str, float]:
    """Return what would still a finger that varies by itself, by its dotted name; nothing for any other."""
    if not (isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes)):
        return {}
    return {path: value for path, value in STILL.items() if attrgetter(path)(system) != value}
