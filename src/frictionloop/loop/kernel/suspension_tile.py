"""The tiles of the force sensor: its suspension over a substep, and its reading at t_k."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import load, peek, poke, store
from frictionloop.loop.kernel.motion_tile import DIRECTION
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import fma
from frictionloop.sensing.suspended import (
    Converter,
    SuspensionCoefficients,
    SuspensionState,
    convert_step,
    suspension_step,
)


def lift_sensor(lifting: Lifting) -> tuple[Any, Any]:
    """Lift the suspension over one substep, and the reading at t_k with its noise and converter."""
    width, compiled, count = lifting
    state_rows, given_rows, force = rows("suspension"), rows("suspension_coefficients"), ROW["contact_force"]
    direction, pushed, reading = ROW["motion"] + DIRECTION, ROW["driven"], ROW["measurement"]
    noise, noise_rows, normal, converter_rows = (
        ROW["noise"],
        rows("noise_coefficients"),
        ROW["normal"],
        rows("converter"),
    )

    @compiled
    def suspend(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            f = fma(peek(s, direction * width + i), peek(s, pushed * width + i), peek(s, force * width + i))
            given = SuspensionCoefficients(*load(s, i, width, given_rows))
            state = SuspensionState(*load(s, i, width, state_rows))
            store(s, i, width, state_rows, suspension_step(state, f, given))

    @compiled
    def read(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            n_k = peek(s, noise * width + i)
            behind_pole = peek(s, state_rows[2] * width + i) + n_k
            poke(s, reading * width + i, convert_step(behind_pole, Converter(*load(s, i, width, converter_rows))))
            decay, gain = load(s, i, width, noise_rows)
            poke(s, noise * width + i, fma(decay, n_k, gain * peek(s, normal * width + i)))

    return suspend, read
