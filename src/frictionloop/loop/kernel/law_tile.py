"""The tile of a control law, with the lookup table and the overdrive behind it."""

from __future__ import annotations

from typing import Any

from frictionloop.control.law import Law
from frictionloop.control.lookup import interpolate_step, inverse_step, table_position
from frictionloop.control.overdrive import OverdriveGains, overdrive_step
from frictionloop.loop.kernel.access import doubles, load, peek, poke, store
from frictionloop.loop.kernel.slab import ROW, law_rows, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.sensing.measurement import Measurement


def build_law(lifting: Lifting, law: Law) -> Any:
    """Lift a law's tick."""
    decide, limits = lift_law(lifting, law, overdriven=True)

    @lifting.compiled
    def control(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if k == 0:
            limits(s, n)
        decide(s, n, o.dt, doubles(o.table), o.table_size)

    return control


def lift_law(lifting: Lifting, law: Law, overdriven: bool = False) -> tuple[Any, Any]:
    """Return the parts that decide, and that prepare the commands at the limits of the clamp.

    With the exact inverse law and lookup are one loop, so that the force command stays in a register; a table is a
    gather, which does not vectorise, and has a loop of its own.
    """
    width, compiled, count = lifting
    setpoint, u_row, command, believed = ROW["setpoint"], ROW["u"], ROW["command"], ROW["overdrive"]
    law_step, (state_rows, gain_rows) = law.step, law_rows(law)
    measurement_rows, command_rows = Measurement(*rows("measurement")), (u_row, ROW["saturated"])
    model_rows, drive_rows = rows("model"), OverdriveGains(*rows("overdrive_gains"))
    exact, limits, low, high, at_limits = lift_lookup(lifting, law)

    @compiled
    def decide(s, i, dt):  # type: ignore[no-untyped-def]
        measured, given = load(s, i, width, measurement_rows), load(s, i, width, gain_rows)
        state, wanted = law_step(load(s, i, width, state_rows), measured, peek(s, setpoint * width + i), given, dt)
        store(s, i, width, state_rows, state)
        store(s, i, width, command_rows, wanted)
        return wanted[0]

    @compiled
    def exact_or_limit(s, i, u):  # type: ignore[no-untyped-def]
        # A lane alone waits for the logarithm and the root; at a limit of the clamp their result is known, and the
        # processor, which predicts the branch, runs ahead. Lanes in a tile would only lose by it.
        if u == peek(s, low * width + i):
            return peek(s, at_limits * width + i)
        if u == peek(s, high * width + i):
            return peek(s, (at_limits + 1) * width + i)
        return exact(s, i, u)

    invert = exact_or_limit if width == 1 else exact

    @compiled
    def look_up(s, i, table):  # type: ignore[no-untyped-def]
        _, _, low, cells_per_n, last = load(s, i, width, model_rows)
        cell, fraction = table_position(peek(s, u_row * width + i), low, cells_per_n, last)
        square_0, square_1 = peek(table, cell * width + i), peek(table, (cell + 1) * width + i)
        poke(s, command * width + i, interpolate_step(fraction, square_0, square_1))

    @compiled
    def control(s, n, dt, table, table_size):  # type: ignore[no-untyped-def]
        if table_size == 0:
            for i in range(count(n)):
                poke(s, command * width + i, invert(s, i, decide(s, i, dt)))
        else:
            for i in range(count(n)):
                decide(s, i, dt)
            for i in range(count(n)):
                look_up(s, i, table)

    @compiled
    def control_overdriven(s, n, dt, table, table_size):  # type: ignore[no-untyped-def]
        control(s, n, dt, table, table_size)
        for i in range(count(n)):
            gains = load(s, i, width, drive_rows)
            a, c = overdrive_step(peek(s, believed * width + i), peek(s, command * width + i), gains)
            poke(s, believed * width + i, a)
            poke(s, command * width + i, c)

    return control_overdriven if overdriven else control, limits


def lift_lookup(lifting: Lifting, law: Law) -> tuple[Any, Any, int, int, int]:
    """Return the exact lookup of a lane, what prepares it at the limits of the clamp, and the rows of these."""
    width, compiled, count = lifting
    model, at_limits = ROW["model"], ROW["at_limits"]
    _, gain_rows = law_rows(law)
    low, high = gain_rows[-2:]

    @compiled
    def exact(s, i, u):  # type: ignore[no-untyped-def]
        return inverse_step(u, peek(s, model * width + i), peek(s, (model + 1) * width + i))

    @compiled
    def limits(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(s, at_limits * width + i, exact(s, i, peek(s, low * width + i)))
            poke(s, (at_limits + 1) * width + i, exact(s, i, peek(s, high * width + i)))

    return exact, limits, low, high, at_limits
