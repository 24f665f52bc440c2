"""What must be equal for two systems to run in one tile, and how the command's delay divides a period."""

from __future__ import annotations

import math

from frictionloop.loop.exchange import LAWS, STILL, STROKES
from frictionloop.loop.quadrature import MAX_SEGMENTS, PLATE_PER_SEGMENT, segments_needed
from frictionloop.loop.slab import NODES_MAX
from frictionloop.parameters import Skin, Strokes, System
from frictionloop.physics.sources import highest_hz
from frictionloop.quantities import FrictionloopError
from frictionloop.sensing.touch import check_follows

STRUCTURAL = ("kind", "rate_hz", "table_size", "delay_s", "plate.cutoff_hz", "plate.frequency_hz", "plate.q", "contact")
"""Last words of the paths whose values decide which systems can share a tile."""
SUBSTEP_S = 20e-6
"""Longest substep of a bench: the contact errs by less than a millinewton (docs/contact)."""
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
        *(segments_of(system) if kernel_of(system) == "quadrature" else (*substeps_of(system), switch_s(system))),
        system.sensor.kind,
        contact_of(system),
        system.motion.kind,
        c.kind,
    )


def kernel_of(system: System) -> str:
    """Return which kernel runs a system: by quadrature what feeds nothing back within a period, else by substeps."""
    still = system.motion.kind == "sliding" and system.finger.kind == "rigid"
    return "quadrature" if still and system.sensor.kind == "lowpass" else "substeps"


def substeps_of(system: System) -> tuple[int, int]:
    """Return the substeps of a period before and after the command changes, each at most SUBSTEP_S long."""
    check_follows(system.motion, system.touch)
    _check_disturbance(system)
    period, switch = 1.0 / system.controller.rate_hz, switch_s(system)
    before, after = (math.ceil(length / SUBSTEP_S - 1e-9) for length in (switch, period - switch))
    if before + after >= NODES_MAX:
        least = 1.0 / (SUBSTEP_S * (NODES_MAX - 2))
        raise FrictionloopError(
            f"controller.rate_hz = {system.controller.rate_hz:g} Hz: must be at least {least:g} Hz on a bench, whose "
            f"substeps are {1e6 * SUBSTEP_S:g} us"
        )
    return before, max(after, 1)


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
    _check_disturbance(system)
    plate, period, switch = system.plate.cutoff_hz, 1.0 / system.controller.rate_hz, switch_s(system)
    before, after = segments_needed(plate, switch), segments_needed(plate, period - switch)
    if max(before, after) > MAX_SEGMENTS:
        most = PLATE_PER_SEGMENT * MAX_SEGMENTS * system.controller.rate_hz
        raise FrictionloopError(
            f"plate.cutoff_hz = {plate:g} Hz: must be at most {most:g} Hz at controller.rate_hz = "
            f"{system.controller.rate_hz:g} Hz (a faster envelope is over within the period and cannot be resolved)"
        )
    return before, after


def _check_disturbance(system: System) -> None:
    half, highest = system.controller.rate_hz / 2, highest_hz(system.disturbance)
    if highest > half:
        name = "frequency_hz" if system.disturbance.kind == "sine" else "start_hz and stop_hz"
        raise FrictionloopError(
            f"disturbance.{name} = {highest:g} Hz: must be at most half of controller.rate_hz, {half:g} Hz"
        )


def contact_of(system: System) -> int:
    """Return the number of the contact law in the kernel."""
    return LAWS.index(system.finger.contact if isinstance(system.finger, Skin) else "rigid")


def moving_of(system: System) -> int:
    """Return who moves the finger."""
    return STROKES if isinstance(system.motion, Strokes) else STILL
