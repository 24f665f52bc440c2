"""The tiles of a bench's period: what is sensed at t_k, and what finger and sensor do until t_k+1."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.irregular_ticks import late_step, lift_delay
from frictionloop.loop.kernel.motion_tile import lift_motion
from frictionloop.loop.kernel.signal_generation import lift_spread
from frictionloop.loop.kernel.slab import ROW, vibration_rows
from frictionloop.loop.kernel.slab_access import doubles, load, store
from frictionloop.loop.kernel.step_lifting import Lifting, lift
from frictionloop.physics.finger_step import FORCES, heading_step, limits_of, settled_of, substep_of
from frictionloop.physics.plate import pulse_step
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.counter_noise import BLOCK
from frictionloop.quantities.scalar_math import fma, step
from frictionloop.sensing.force_sensor import convert_step, suspension_step

_NOW, _CONTACT, _GIVEN, _AGEING = ROW["motion"], ROW["contact"], ROW["contact_coefficients"], ROW["ageing"]
_LIMIT, _SPRINGS, _APPLIED = ROW["limit_n"], ROW["suspension"], ROW["applied"]


@step
def pulses_step(commands, ceiling_um, ticks):  # type: ignore[no-untyped-def]
    """The commands in force as pulses of whole clock ticks can give them."""
    return pulse_step(commands[0], ceiling_um, ticks), pulse_step(commands[1], ceiling_um, ticks)


def lift_settle(lifting: Lifting, contact: str) -> Any:
    """Return what puts finger and sensor where they had time enough to be before t = 0."""
    settled = settled_of(contact)

    @step
    def settle(finger, disturbance_n):  # type: ignore[no-untyped-def]
        force_n, lag_m = settled(*finger)
        pushed_n = fma(finger[1].direction, disturbance_n, force_n)
        return lag_m, force_n, pushed_n, pushed_n

    finger = _LIMIT, _NOW, ROW["stroke_plan"].speed_m_s, ROW["compliance"]
    results = _CONTACT.lag_m, _CONTACT.force_n, _SPRINGS.spring_n, _SPRINGS.filtered_n
    return lift(lifting, settle, (finger, ROW["disturbance"]), results)


def lift_tell(lifting: Lifting, contact: str, vibration: Vibration) -> Any:
    """Return what tells f_a along the stroke, what is reachable at t_k, and the reading with noise and converter."""
    limits_at, force_at = limits_of(vibration), FORCES[contact]

    @step
    def limited(limit_n, now, um, effect, ageing, contact, given):  # type: ignore[no-untyped-def]
        top_n, floor_n, limit_n = limits_at(limit_n, now, *um, effect, contact.age_s, ageing)
        return top_n, floor_n, now.direction * force_at(limit_n, now, contact, given)

    @step
    def read(noise_n, springs, converter, coefficients, normal):  # type: ignore[no-untyped-def]
        reading_n = convert_step(springs.filtered_n + noise_n, converter)
        return reading_n, fma(coefficients.decay, noise_n, coefficients.gain * normal)

    @step
    def tell(finger, sensor):  # type: ignore[no-untyped-def]
        return limited(*finger), read(*sensor)

    um = ROW["amplitude"], ROW["max_amplitude"]
    finger = _LIMIT, _NOW, um, vibration_rows(vibration), _AGEING, _CONTACT, _GIVEN
    sensor = ROW["noise"], _SPRINGS, ROW["converter"], ROW["noise_coefficients"], ROW["normal"]
    results = (ROW["nominal"], ROW["floor"], ROW["friction"]), (ROW["measurement"].force, ROW["noise"])
    return lift(lifting, tell, (finger, sensor), results)


def lift_substep(lifting: Lifting, contact: str, vibration: Vibration) -> Any:
    """Return ``substep(s, n, j, of)``: plate, friction limit, contact and suspension over substep j of a period."""
    advance = substep_of(contact, vibration)

    @step
    def substep(j, of, finger, disturbance_n, springs, given):  # type: ignore[no-untyped-def]
        amplitude_um, contact, force_n = advance(j, of, *finger)
        pushed_n = fma(finger[0].direction, disturbance_n, force_n)
        return amplitude_um, contact, suspension_step(springs, pushed_n, given)

    drive = *_APPLIED, ROW["switch"], ROW["max_amplitude"], ROW["amplitude"], ROW["plate_coefficients"]
    finger = _NOW, ROW["motion_next"], *drive, vibration_rows(vibration), _LIMIT, _AGEING, _CONTACT, _GIVEN
    sensor = ROW["driven"], _SPRINGS, ROW["suspension_coefficients"]
    return lift(lifting, substep, (finger, *sensor), (ROW["amplitude"], _CONTACT, _SPRINGS))


def build_sense(lifting: Lifting, contact: str, vibration: Vibration, moving: bool) -> Any:
    """Return the tile that brings the signals of t_k, moves the finger on, and reads force, position and load."""
    compiled, spread = lifting.compiled, lift_spread(lifting)
    take_over, follow, go_on, begin, _ = lift_motion(lifting)
    settle, tell = lift_settle(lifting, contact), lift_tell(lifting, contact, vibration)
    time_switch = lift(lifting, late_step, (*ROW["timing"], ROW["timing_draws"][0]), ROW["switch"])
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


def build_guide(lifting: Lifting) -> Any:
    """Return the tile that lets a finger go where its path says: to its place at t_k+1, at that speed and load."""
    (width, compiled, count), heading = lifting, heading_step
    following = *ROW["motion_next"][:3], ROW["motion_next"].direction, ROW["motion_next"].place

    @compiled
    def guide(s, n, k, at, o):  # type: ignore[no-untyped-def]
        position, speed, pressed = load(doubles(o.path), 3 * k, 1, (0, 1, 2))
        for i in range(count(n)):
            direction = heading(speed, load(s, i, width, _NOW.direction))
            store(s, i, width, following, (position, speed, pressed, direction, position))

    return guide


def build_move(lifting: Lifting, contact: str, vibration: Vibration, moving: bool) -> Any:
    """Return the tile of the plant over one period: substeps of finger and suspension under the commands in force."""
    compiled, spread, driven = lifting.compiled, lift_spread(lifting), ROW["driven"]
    apply_late, substep = lift_delay(lifting), lift_substep(lifting, contact, vibration)
    (*_, accept), limits = lift_motion(lifting), (ROW["max_amplitude"], ROW["pulse_ticks"])
    pulse = lift(lifting, pulses_step, (_APPLIED, *limits), _APPLIED)

    @compiled
    def move(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if moving and o.given > 0:
            accept(s, n, doubles(o.roughness))
        apply_late(s, n, k, o)
        if o.pulsed:
            pulse(s, n)
        place = k % BLOCK
        for j in range(o.segments):
            spread(s, n, driven, doubles(o.disturbance), (j + 1) * BLOCK + place, o.disturbance_shared)
            substep(s, n, float(j), float(o.segments))

    return move
