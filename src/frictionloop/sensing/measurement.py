"""What the sensors tell the controller once per control period."""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.quantities.class_help import brief


@brief
class Measurement(NamedTuple):
    """One sample of the sensors; a controller may use any part of it."""

    force: float
    """Measured friction force f_m, N, positive when it opposes the motion."""
    position: float = 0.0
    """Position along the stroke, m."""
    speed: float = 0.0
    """Sliding speed, m/s."""
    load: float = 0.0
    """Normal force, N."""
    valid: float = 1.0
    """1 while the finger is on the plate and sliding, else 0."""
