"""The tile of a control law and the lookup table behind it."""

from __future__ import annotations

from typing import Any

from frictionloop.control.law import Law
from frictionloop.control.lookup import interpolate_step, inverse_step, table_position
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.slab_access import load, peek, poke, store
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.sensing.measurement import Measurement


def build_control(lifting: Lifting, law: Law) -> Any:
    """Lift a control law and the lookup; return the tile and one that prepares the commands at the limits of the clamp.

    With the exact inverse law and lookup are one loop, so that the force command stays in a register; a table is a
    gather, which does not vectorise, and has a loop of its own.
    """
    width, compiled, count = lifting
    setpoint, u_row, model, command = ROW["setpoint"], ROW["u"], ROW["model"], ROW["command"]
    state_rows, law_step = rows("controller_state", law.states), law.step
    gain_rows, at_limits = (*rows("controller_gains", law.gains), *rows("clamp")), ROW["at_limits"]
    low, high = rows("clamp")
    measurement_rows, command_rows, model_rows = rows("measurement"), (u_row, ROW["saturated"]), rows("model")

    @compiled
    def decide(s, i, dt):  # type: ignore[no-untyped-def]
        f, x, v, normal_force, valid = load(s, i, width, measurement_rows)
        measured = Measurement(f, x, v, normal_force, valid)
        given = load(s, i, width, gain_rows)
        state, wanted = law_step(load(s, i, width, state_rows), measured, peek(s, setpoint * width + i), given, dt)
        store(s, i, width, state_rows, state)
        store(s, i, width, command_rows, wanted)
        return wanted[0]

    @compiled
    def exact(s, i, u):  # type: ignore[no-untyped-def]
        return inverse_step(u, peek(s, model * width + i), peek(s, (model + 1) * width + i))

    @compiled
    def exact_or_limit(s, i, u):  # type: ignore[no-untyped-def]
        # A lane alone waits for the logarithm and the root; at a limit of the clamp their result is known, and the
        # processor, which predicts the branch, runs ahead. Lanes in a tile would only lose by it.
        if u == peek(s, low * width + i):
            return peek(s, at_limits * width + i)
        if u == peek(s, high * width + i):
            return peek(s, (at_limits + 1) * width + i)
        return exact(s, i, u)

    @compiled
    def limits(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(s, at_limits * width + i, exact(s, i, peek(s, low * width + i)))
            poke(s, (at_limits + 1) * width + i, exact(s, i, peek(s, high * width + i)))

    invert = exact_or_limit if width == 1 else exact

    @compiled
    def control(s, n, number, dt, table, table_size):  # type: ignore[no-untyped-def]
        if table_size == 0:
            for i in range(count(n)):
                poke(s, command * width + i, invert(s, i, decide(s, i, dt)))
        else:
            for i in range(count(n)):
                decide(s, i, dt)
            for i in range(count(n)):
                _, _, low, cells_per_n, last = load(s, i, width, model_rows)
                cell, fraction = table_position(peek(s, u_row * width + i), low, cells_per_n, last)
                square_0, square_1 = peek(table, cell * width + i), peek(table, (cell + 1) * width + i)
                poke(s, command * width + i, interpolate_step(fraction, square_0, square_1))

    return control, limits
