"""The tile of a control law and the lookup table behind it."""

from __future__ import annotations

from typing import Any

from frictionloop.control.lookup import interpolate_step, inverse_step, table_position
from frictionloop.loop.slab import ROW, load, peek, poke, rows, store
from frictionloop.loop.tiles import compiled, lane_count
from frictionloop.sensing.measurement import Measurement


def build_control(width: int, law: Any, states: int, gains: int) -> Any:
    """Lift a control law ``law(state, measurement, setpoint, gains, dt) -> state, (u, saturated)`` and the lookup.

    With the exact inverse both are one loop, so that the force command stays in a register; a table is a gather, which
    does not vectorise, and has a loop of its own.
    """
    count = lane_count(width)
    setpoint, u_row, model, command = ROW["setpoint"], ROW["u"], ROW["model"], ROW["command"]
    state_rows, gain_rows = rows("controller_state", states), rows("controller_gains", gains)
    measurement_rows, command_rows, model_rows = rows("measurement"), (u_row, ROW["saturated"]), rows("model")

    @compiled
    def decide(s, i, dt):  # type: ignore[no-untyped-def]
        f, x, v, normal_force, valid = load(s, i, width, measurement_rows)
        measured = Measurement(f, x, v, normal_force, valid)
        given = load(s, i, width, gain_rows)
        state, wanted = law(load(s, i, width, state_rows), measured, peek(s, setpoint * width + i), given, dt)
        store(s, i, width, state_rows, state)
        store(s, i, width, command_rows, wanted)
        return wanted[0]

    @compiled
    def control(s, n, dt, table, table_size):  # type: ignore[no-untyped-def]
        if table_size == 0:
            for i in range(count(n)):
                a = inverse_step(decide(s, i, dt), peek(s, model * width + i), peek(s, (model + 1) * width + i))
                poke(s, command * width + i, a)
        else:
            for i in range(count(n)):
                decide(s, i, dt)
            for i in range(count(n)):
                _, _, low, cells_per_n, last = load(s, i, width, model_rows)
                cell, fraction = table_position(peek(s, u_row * width + i), low, cells_per_n, last)
                square_0, square_1 = peek(table, cell * width + i), peek(table, (cell + 1) * width + i)
                poke(s, command * width + i, interpolate_step(fraction, square_0, square_1))

    return control
