"""The parts of tiles for what a finger feels and a sensor reads: a substep, the start, and what is told at t_k."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.slab import ROW, vibration_rows
from frictionloop.loop.kernel.tiles import Lifting, chain, lift
from frictionloop.physics.finger_step import FORCES, limits_of, settled_of, substep_of
from frictionloop.physics.pulses import pulse_step
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.arithmetic import fma, step
from frictionloop.sensing.suspended import convert_step, suspension_step

_NOW, _CONTACT, _GIVEN, _STATIC = ROW["motion"], ROW["contact"], ROW["contact_coefficients"], ROW["static"]
_FORCE, _LIMIT, _VIBRATED = ROW["contact_force"], ROW["limit_n"], ROW["vibrated_limit"]
_SPRINGS = ROW["suspension"]


@step
def pushed_step(direction, disturbance_n, force_n, state, given):  # type: ignore[no-untyped-def]
    """The suspension under friction and disturbance."""
    return suspension_step(state, fma(direction, disturbance_n, force_n), given)


@step
def read_step(noise_n, state, converter, coefficients, normal):  # type: ignore[no-untyped-def]
    """The reading at t_k, and the noise of the next."""
    decay, gain = coefficients
    return convert_step(state.filtered_n + noise_n, converter), fma(decay, noise_n, gain * normal)


@step
def at_rest_step(direction, disturbance_n, force_n):  # type: ignore[no-untyped-def]
    """Spring and reading of a sensor that has settled on a force."""
    pushed = fma(direction, disturbance_n, force_n)
    return pushed, pushed


@step
def along_step(direction, force_n):  # type: ignore[no-untyped-def]
    """Force along the stroke, positive where it opposes it."""
    return direction * force_n


def lift_finger(lifting: Lifting, contact: str, vibration: Vibration) -> Any:
    """Return ``finger(s, n, j, of)``: plate, friction limit and contact over substep j of a period."""
    drive = *ROW["applied"], ROW["switch"], ROW["max_amplitude"], ROW["amplitude"], ROW["plate_coefficients"]
    given = _NOW, ROW["motion_next"], *drive, vibration_rows(vibration), _LIMIT, _STATIC, _CONTACT, _GIVEN
    return lift(lifting, substep_of(contact, vibration), given, (ROW["amplitude"], _CONTACT, _FORCE))


def lift_suspend(lifting: Lifting) -> Any:
    """Return the suspension over one substep."""
    given = _NOW.direction, ROW["driven"], _FORCE, _SPRINGS, ROW["suspension_coefficients"]
    return lift(lifting, pushed_step, given, _SPRINGS)


def lift_read(lifting: Lifting) -> Any:
    """Return the reading at t_k with its noise and converter."""
    given = ROW["noise"], _SPRINGS, ROW["converter"], ROW["noise_coefficients"], ROW["normal"]
    return lift(lifting, read_step, given, (ROW["measurement"].force, ROW["noise"]))


def lift_settle(lifting: Lifting, contact: str) -> Any:
    """Return what puts finger and sensor where they had time enough to be before t = 0."""
    given = _LIMIT, _NOW, ROW["stroke_plan"].speed_m_s, ROW["compliance"], _GIVEN
    results = _FORCE, _CONTACT.lag_m, _CONTACT.bristle_m, _CONTACT.limit_m
    finger = lift(lifting, settled_of(contact), given, results)
    pushed = _NOW.direction, ROW["disturbance"], _FORCE
    return chain(lifting, finger, lift(lifting, at_rest_step, pushed, (_SPRINGS.spring_n, _SPRINGS.filtered_n)))


def lift_tell(lifting: Lifting, contact: str, vibration: Vibration) -> Any:
    """Return what tells f_a and what is reachable at t_k."""
    effect, slip = vibration_rows(vibration), (_CONTACT.lag_speed_m_s, _STATIC)
    given = _LIMIT, _NOW, ROW["amplitude"], ROW["max_amplitude"], effect, *slip
    limits = lift(lifting, limits_of(vibration), given, (ROW["nominal"], ROW["floor"], _VIBRATED))
    force = lift(lifting, FORCES[contact], (_VIBRATED, _NOW, _CONTACT, _GIVEN), _FORCE)
    return chain(lifting, limits, force, lift(lifting, along_step, (_NOW.direction, _FORCE), ROW["friction"]))


def lift_pulses(lifting: Lifting) -> Any:
    """Return what makes the commands in force ones that pulses of whole clock ticks can give."""
    drive = ROW["max_amplitude"], ROW["pulse_ticks"]
    return chain(lifting, *(lift(lifting, pulse_step, (row, *drive), row) for row in ROW["applied"]))
