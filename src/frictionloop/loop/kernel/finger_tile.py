"""The parts of tiles for what a finger feels and a sensor reads: a substep, the start, and what is told at t_k."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.lift import lift
from frictionloop.loop.kernel.motion_tile import NEXT as AFTER
from frictionloop.loop.kernel.motion_tile import NOW
from frictionloop.loop.kernel.slab import ROW, rows, vibration_rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.contact import ContactCoefficients, ContactState
from frictionloop.physics.finger_step import FORCES, Static, limits_of, settled_of, substep_of
from frictionloop.physics.motion import StrokePlan
from frictionloop.physics.plate import PlateCoefficients, pulse_step
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.arithmetic import fma, step
from frictionloop.sensing.suspended import (
    Converter,
    NoiseCoefficients,
    SuspensionCoefficients,
    SuspensionState,
    convert_step,
    suspension_step,
)

CONTACT, GIVEN = ContactState(*rows("contact")), ContactCoefficients(*rows("contact_coefficients"))
STATIC, _SPRINGS = Static(*rows("static")), SuspensionState(*rows("suspension"))
_FORCE, _LIMIT, _VIBRATED = ROW["contact_force"], ROW["limit_n"], ROW["vibrated_limit"]


@step
def pushed_step(direction, disturbance_n, force_n, state, given):  # type: ignore[no-untyped-def]
    """The suspension under friction and disturbance."""
    return suspension_step(state, fma(direction, disturbance_n, force_n), given)


@step
def read_step(noise_n, state, converter, decay, gain, normal):  # type: ignore[no-untyped-def]
    """The reading at t_k, and the noise of the next."""
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
    plate = PlateCoefficients(*rows("plate_coefficients"))
    drive = *rows("applied"), ROW["switch"], ROW["max_amplitude"], ROW["amplitude"], plate
    given = NOW, AFTER, *drive, vibration_rows(vibration), _LIMIT, STATIC, CONTACT, GIVEN
    return lift(lifting, substep_of(contact, vibration), given, (ROW["amplitude"], CONTACT, _FORCE), extra=2)


def lift_sensor(lifting: Lifting) -> tuple[Any, Any]:
    """Return the suspension over one substep, and the reading at t_k with its noise and converter."""
    coefficients = SuspensionCoefficients(*rows("suspension_coefficients"))
    suspend = lift(lifting, pushed_step, (NOW.direction, ROW["driven"], _FORCE, _SPRINGS, coefficients), _SPRINGS)
    noise = NoiseCoefficients(*rows("noise_coefficients"))
    given = ROW["noise"], _SPRINGS, Converter(*rows("converter")), *noise, ROW["normal"]
    return suspend, lift(lifting, read_step, given, (ROW["measurement"], ROW["noise"]))


def lift_settle(lifting: Lifting, contact: str) -> Any:
    """Return what puts finger and sensor where they had time enough to be before t = 0."""
    full_speed = StrokePlan(*rows("stroke_plan")).speed_m_s
    given = _LIMIT, NOW, full_speed, ROW["compliance"], GIVEN
    results = _FORCE, CONTACT.lag_m, CONTACT.bristle_m, CONTACT.limit_m
    finger = lift(lifting, settled_of(contact), given, results)
    pushed = NOW.direction, ROW["disturbance"], _FORCE
    sensor = lift(lifting, at_rest_step, pushed, (_SPRINGS[0], _SPRINGS[2]))

    @lifting.compiled
    def settle(s, n):  # type: ignore[no-untyped-def]
        finger(s, n)
        sensor(s, n)

    return settle


def lift_tell(lifting: Lifting, contact: str, vibration: Vibration) -> Any:
    """Return what tells f_a and what is reachable at t_k."""
    effect, top = vibration_rows(vibration), (ROW["nominal"], ROW["floor"], _VIBRATED)
    given = _LIMIT, NOW, ROW["amplitude"], ROW["max_amplitude"], effect, CONTACT.lag_speed_m_s, STATIC
    limits = lift(lifting, limits_of(vibration), given, top)
    force = lift(lifting, FORCES[contact], (_VIBRATED, NOW, CONTACT, GIVEN), _FORCE)
    along = lift(lifting, along_step, (NOW.direction, _FORCE), ROW["friction"])

    @lifting.compiled
    def tell(s, n):  # type: ignore[no-untyped-def]
        limits(s, n)
        force(s, n)
        along(s, n)

    return tell


def lift_pulses(lifting: Lifting) -> Any:
    """Return what makes the commands in force ones that pulses of whole clock ticks can give."""
    (old, new), largest, ticks = rows("applied"), ROW["max_amplitude"], ROW["pulse_ticks"]
    before = lift(lifting, pulse_step, (old, largest, ticks), old)
    after = lift(lifting, pulse_step, (new, largest, ticks), new)

    @lifting.compiled
    def pulse(s, n):  # type: ignore[no-untyped-def]
        before(s, n)
        after(s, n)

    return pulse
