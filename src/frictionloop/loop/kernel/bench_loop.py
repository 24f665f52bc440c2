"""The tiles of a bench's period: what is sensed at t_k, and what the plant does until t_k+1."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles
from frictionloop.loop.kernel.clock_tile import lift_delay, lift_timing
from frictionloop.loop.kernel.finger_tile import (
    lift_finger,
    lift_pulses,
    lift_read,
    lift_settle,
    lift_suspend,
    lift_tell,
)
from frictionloop.loop.kernel.motion_tile import lift_motion, lift_touch
from frictionloop.loop.kernel.signals import lift_spread
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting, chain
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities.normals import BLOCK


def build_sense(lifting: Lifting, contact: str, vibration: Vibration, moving: bool) -> Any:
    """Return the tile that brings the signals of t_k, moves the finger on, and reads force, position and load."""
    compiled, spread = lifting.compiled, lift_spread(lifting)
    take_over, go_on, begin, _ = lift_motion(lifting)
    follow, time_switch, settle = lift_touch(lifting), lift_timing(lifting), lift_settle(lifting, contact)
    tell = chain(lifting, lift_tell(lifting, contact, vibration), lift_read(lifting))
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
    suspend, accept = lift_suspend(lifting), lift_motion(lifting).accept

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
