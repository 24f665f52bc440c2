"""What must be equal for two systems to run in one tile, and how the command's delay divides a period."""

from __future__ import annotations

import math

from frictionloop.loop.quadrature import MAX_SEGMENTS, PLATE_PER_SEGMENT, segments_needed
from frictionloop.parameters import System
from frictionloop.physics.sources import highest_hz
from frictionloop.quantities import FrictionloopError

STRUCTURAL = ("kind", "rate_hz", "table_size", "delay_s", "plate.cutoff_hz")
"""Last words of the paths whose values decide which systems can share a tile."""
COUPLED = ("start_hz", "stop_hz", "low_hz", "high_hz", "start_s", "stop_s", "_um", "_um2")
"""Last words of the paths whose values are checked against one another."""


def structure(system: System) -> tuple[object, ...]:
    """Return what must be equal for two systems to share a tile."""
    c = system.controller
    return (
        system.setpoint.kind,
        system.disturbance.kind,
        c.rate_hz,
        c.model.table_size,
        *segments_of(system),
        system.plate.kind,
        system.sensor.kind,
        c.kind,
    )


def delay_periods(system: System) -> int:
    """Return the whole control periods of the delay."""
    return math.floor(system.controller.delay_s * system.controller.rate_hz + 1e-9)


def switch_s(system: System) -> float:
    """Return how long after the sample the command in force changes, in s; 0 when it changes at the sample."""
    c = system.controller
    rest = c.delay_s - delay_periods(system) / c.rate_hz
    return rest if rest > 1e-9 / c.rate_hz else 0.0


def segments_of(system: System) -> tuple[int, int]:
    """Return the segments of a period before and after the command changes, at least one in all.

    Raises ``FrictionloopError`` for a plate or a disturbance too fast for the nodes of a period to follow.
    """
    half, highest = system.controller.rate_hz / 2, highest_hz(system.disturbance)
    if highest > half:
        name = "frequency_hz" if system.disturbance.kind == "sine" else "start_hz and stop_hz"
        raise FrictionloopError(
            f"disturbance.{name} = {highest:g} Hz: must be at most half of controller.rate_hz, {half:g} Hz"
        )
    plate, period, switch = system.plate.cutoff_hz, 1.0 / system.controller.rate_hz, switch_s(system)
    before, after = segments_needed(plate, switch), segments_needed(plate, period - switch)
    if max(before, after) > MAX_SEGMENTS:
        most = PLATE_PER_SEGMENT * MAX_SEGMENTS * system.controller.rate_hz
        raise FrictionloopError(
            f"plate.cutoff_hz = {plate:g} Hz: must be at most {most:g} Hz at controller.rate_hz = "
            f"{system.controller.rate_hz:g} Hz (a faster envelope is over within the period and cannot be resolved)"
        )
    return before, after
