"""What must be equal for two systems to run in one tile, and how the command's delay divides a period."""

from __future__ import annotations

import math

from frictionloop.loop.kernel.period_quadrature import (
    MAX_SEGMENTS,
    PLATE_PER_SEGMENT,
    segments_needed,
    suits_quadrature,
)
from frictionloop.loop.kernel.slab import NODES_MAX
from frictionloop.parameters import Skin, Strokes, System
from frictionloop.physics.signal_values import highest_hz
from frictionloop.physics.vibration import vibration_of
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect_program import Program
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.sensing.finger_tracking import check_follows

STRUCTURAL = (
    "kind",
    "pulse_ticks",
    "rate_hz",
    "table_size",
    "delay_s",
    "jitter_s",
    "lost_ticks",
    "open_until_s",
    "contact",
)
"""Last words of the paths whose values decide which systems can share a tile."""
SUBSTEP_S = 20e-6
"""Longest substep of a bench: the contact errs by less than a millinewton (docs/model)."""
COUPLED = (
    *("start_hz", "stop_hz", "low_hz", "high_hz", "start_s", "stop_s", "_um", "_um2"),
    *("speed_mm_s", "stroke_mm", "reversal_s", "contact_s", "landing_s", "fastest_mm_s", "length_mm"),
    *("range_n", "setpoint.offset_n", "setpoint.amplitude_n", "model.nominal_n"),
    *("notch_depth", "notch_width"),
)
"""Last words of the paths whose values are checked against one another."""


def structure(system: System) -> tuple[object, ...]:
    """Return what must be equal for two systems to share a tile."""
    c = system.controller
    return (
        effect_of(system) or system.setpoint.kind,
        system.disturbance.kind,
        c.rate_hz,
        c.model.table_size,
        *(segments_of(system) if kernel_of(system) == "quadrature" else (substeps_of(system), is_irregular(system))),
        system.sensor.kind,
        vibration_of(system.friction).kind,
        contact_of(system),
        system.motion.kind,
        c.kind,
        open_until(system),
        system.plate.pulse_ticks > 0,
    )


def kernel_of(system: System) -> str:
    """Return which kernel runs a system: by quadrature what feeds nothing back within a period, else by substeps."""
    return "quadrature" if suits_quadrature(system) else "substeps"


def substeps_of(system: System) -> int:
    """Return the substeps of a period, each at most SUBSTEP_S long."""
    check_follows(system.motion, system.touch)
    _check_disturbance(system)
    rate = system.controller.rate_hz
    count = math.ceil(1.0 / (rate * SUBSTEP_S) - 1e-9)
    if count >= NODES_MAX:
        raise FrictionloopError(
            f"controller.rate_hz = {rate:g} Hz: must be at least {1.0 / (SUBSTEP_S * (NODES_MAX - 1)):g} Hz"
        )
    return count


def is_irregular(system: System) -> bool:
    """Return whether commands come late by chance or ticks are lost."""
    return system.controller.jitter_s > 0.0 or system.controller.lost_ticks > 0.0


def open_until(system: System) -> int:
    """Return the control period with which the loop closes, the first that does not begin before."""
    return math.ceil(system.controller.open_until_s * system.controller.rate_hz - 1e-9)


def divided(delay_s: float, rate_hz: float) -> tuple[int, float]:
    """Return the whole control periods of a delay, and the s from sample to switch that are left of it."""
    whole = math.floor(delay_s * rate_hz + 1e-9)
    rest = delay_s - whole / rate_hz
    return whole, rest if rest > 1e-9 / rate_hz else 0.0


def delay_periods(system: System) -> int:
    """Return the whole control periods of the delay."""
    return divided(system.controller.delay_s, system.controller.rate_hz)[0]


def switch_s(system: System) -> float:
    """Return how long after the sample the command in force changes, in s; 0 when it changes at the sample."""
    return divided(system.controller.delay_s, system.controller.rate_hz)[1]


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
            f"plate.cutoff_hz = {plate:g} Hz: at most {most:g} Hz at {system.controller.rate_hz:g} Hz"
        )
    return before, after


def _check_disturbance(system: System) -> None:
    half, highest = system.controller.rate_hz / 2, highest_hz(system.disturbance)
    if highest > half:
        name = "frequency_hz" if system.disturbance.kind == "sine" else "start_hz and stop_hz"
        raise FrictionloopError(
            f"disturbance.{name} = {highest:g} Hz: must be at most half of controller.rate_hz, {half:g} Hz"
        )


def effect_of(system: System) -> Program | None:
    """Return the program of an effect that is the set-point."""
    setpoint = system.setpoint
    return setpoint.program(system.touch.load.length_mm) if isinstance(setpoint, EffectSource) else None


def contact_of(system: System) -> str:
    """Return the contact law."""
    return "bristle" if isinstance(system.finger, Skin) else "rigid"


def moves(system: System) -> bool:
    """Return whether the finger moves."""
    return isinstance(system.motion, Strokes)
