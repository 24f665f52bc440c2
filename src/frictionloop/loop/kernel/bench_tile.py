"""The tiles of a bench's period: what is sensed at t_k, and what finger and sensor do until t_k+1."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles
from frictionloop.loop.kernel.clock_tile import lift_delay, lift_timing
from frictionloop.loop.kernel.motion_tile import lift_motion, lift_touch
from frictionloop.loop.kernel.signals import lift_spread
from frictionloop.loop.kernel.slab import ROW, vibration_rows
from frictionloop.loop.kernel.tiles import Lifting, chain, lift
from frictionloop.physics.finger_step import FORCES, limits_of, settled_of, substep_of
from frictionloop.physics.plate import pulse_step
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.arithmetic import fma, step
from frictionloop.quantities.normals import BLOCK
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


def lift_settle(lifting: Lifting, contact: str) -> Any:
    """Return what puts finger and sensor where they had time enough to be before t = 0."""
    given = _LIMIT, _NOW, ROW["stroke_plan"].speed_m_s, ROW["compliance"], _GIVEN
    results = _FORCE, _CONTACT.lag_m, _CONTACT.bristle_m, _CONTACT.limit_m
    finger = lift(lifting, settled_of(contact), given, results)
    pushed = _NOW.direction, ROW["disturbance"], _FORCE
    return chain(lifting, finger, lift(lifting, at_rest_step, pushed, (_SPRINGS.spring_n, _SPRINGS.filtered_n)))


def lift_tell(lifting: Lifting, contact: str, vibration: Vibration) -> Any:
    """Return what tells f_a, what is reachable at t_k, and the reading with its noise and converter."""
    effect, slip = vibration_rows(vibration), (_CONTACT.lag_speed_m_s, _STATIC)
    given = _LIMIT, _NOW, ROW["amplitude"], ROW["max_amplitude"], effect, *slip
    limits = lift(lifting, limits_of(vibration), given, (ROW["nominal"], ROW["floor"], _VIBRATED))
    force = lift(lifting, FORCES[contact], (_VIBRATED, _NOW, _CONTACT, _GIVEN), _FORCE)
    along = lift(lifting, along_step, (_NOW.direction, _FORCE), ROW["friction"])
    noisy = ROW["noise"], _SPRINGS, ROW["converter"], ROW["noise_coefficients"], ROW["normal"]
    read = lift(lifting, read_step, noisy, (ROW["measurement"].force, ROW["noise"]))
    return chain(lifting, limits, force, along, read)


def lift_pulses(lifting: Lifting) -> Any:
    """Return what makes the commands in force ones that pulses of whole clock ticks can give."""
    drive = ROW["max_amplitude"], ROW["pulse_ticks"]
    return chain(lifting, *(lift(lifting, pulse_step, (row, *drive), row) for row in ROW["applied"]))


def build_sense(lifting: Lifting, contact: str, vibration: Vibration, moving: bool) -> Any:
    """Return the tile that brings the signals of t_k, moves the finger on, and reads force, position and load."""
    compiled, spread = lifting.compiled, lift_spread(lifting)
    take_over, go_on, begin, _ = lift_motion(lifting)
    follow, time_switch, settle = lift_touch(lifting), lift_timing(lifting), lift_settle(lifting, contact)
    tell = lift_tell(lifting, contact, vibration)
    setpoint, disturbance, normal = ROW["setpoint"], ROW["disturbance"], ROW["normal"]
    draws, timing_draws = ROW["draws"][0], ROW["timing_draws"][0]

    @compiled
    def sense(s, n, k, at, o):  # type: ignore[no-untyped-def]
        spread(s, n, setpoint, doubles(o.setpoint), at, o.setpoint_shared)
        spread(s, n, disturbance, doubles(o.disturbance), at, o.disturbance_shared)
        spread(s, n, normal, doubles(o.normals), at, o.noise_shared)
        if moving:
            for stream in range(4):
                spread(s, n, draws + stream, doubles(o.draws), stream * BLOCK + at, o.noise_shared)
            if k == 0:
                begin(s, n, doubles(o.roughness))
            take_over(s, n)
        if o.irregular:
            spread(s, n, timing_draws, doubles(o.timing), at, o.noise_shared)
            spread(s, n, timing_draws + 1, doubles(o.timing), BLOCK + at, o.noise_shared)
            time_switch(s, n)
        if k == 0:
            settle(s, n)
        # Also under a finger that the caller moves: from the next period on it may move by itself.
        if moving:
            go_on(s, n, (k + 1) * o.dt, doubles(o.roughness))
        tell(s, n)
        if moving:
            follow(s, n)

    return sense


def build_move(lifting: Lifting, contact: str, vibration: Vibration, moving: bool) -> Any:
    """Return the tile of the plant over one period: substeps of finger and suspension under the commands in force."""
    compiled, spread, driven = lifting.compiled, lift_spread(lifting), ROW["driven"]
    apply_late, pulse, finger = lift_delay(lifting), lift_pulses(lifting), lift_finger(lifting, contact, vibration)
    pushed = _NOW.direction, driven, _FORCE, _SPRINGS, ROW["suspension_coefficients"]
    suspend, (*_, accept) = lift(lifting, pushed_step, pushed, _SPRINGS), lift_motion(lifting)

    @compiled
    def move(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if moving and o.given:
            accept(s, n, doubles(o.roughness))
        apply_late(s, n, k, o)
        if o.pulsed:
            pulse(s, n)
        place = k % BLOCK
        for j in range(o.segments):
            spread(s, n, driven, doubles(o.disturbance), (j + 1) * BLOCK + place, o.disturbance_shared)
            finger(s, n, float(j), float(o.segments))
            suspend(s, n)

    return move
