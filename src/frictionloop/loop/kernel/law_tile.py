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
    (decide, limits), overdrive = lift_law(lifting, law), lift_overdrive(lifting)

    @lifting.compiled
    def control(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if k == 0:
            limits(s, n)
        decide(s, n, o.dt, doubles(o.table), o.table_size)
        overdrive(s, n)

    return control


def lift_law(lifting: Lifting, law: Law) -> tuple[Any, Any]:
    """Return the parts that decide, and that prepare the commands at the limits of the clamp.

    With the exact inverse law and lookup are one loop, so that the force command stays in a register; a table is a
    gather, which does not vectorise, and has a loop of its own.
    """
    width, compiled, count = lifting
    setpoint, command_rows, command = ROW["setpoint"], (ROW["u"], ROW["saturated"]), ROW["command"]
    law_step, (state_rows, gain_rows), measurement_rows = law.step, law_rows(law), Measurement(*rows("measurement"))
    (exact, look_up), (limits, exact_or_limit) = lift_lookup(lifting), lift_limits(lifting, law)

    @compiled
    def decide(s, i, dt):  # type: ignore[no-untyped-def]
        measured, given = load(s, i, width, measurement_rows), load(s, i, width, gain_rows)
        state, wanted = law_step(load(s, i, width, state_rows), measured, peek(s, setpoint * width + i), given, dt)
        store(s, i, width, state_rows, state)
        store(s, i, width, command_rows, wanted)
        return wanted[0]

    # A lane alone waits for the logarithm and the root; at a limit of the clamp their result is known, and the
    # processor, which predicts the branch, runs ahead. Lanes in a tile would only lose by it.
    invert = exact_or_limit if width == 1 else exact

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

    return control, limits


def lift_lookup(lifting: Lifting) -> tuple[Any, Any]:
    """Return the exact inverse of a force, and the look-up of the command of a lane in the table."""
    width, compiled, _ = lifting
    model, model_rows, u_row, command = ROW["model"], rows("model"), ROW["u"], ROW["command"]

    @compiled
    def exact(s, i, u):  # type: ignore[no-untyped-def]
        return inverse_step(u, peek(s, model * width + i), peek(s, (model + 1) * width + i))

    @compiled
    def look_up(s, i, table):  # type: ignore[no-untyped-def]
        _, _, low, cells_per_n, last = load(s, i, width, model_rows)
        cell, fraction = table_position(peek(s, u_row * width + i), low, cells_per_n, last)
        square_0, square_1 = peek(table, cell * width + i), peek(table, (cell + 1) * width + i)
        poke(s, command * width + i, interpolate_step(fraction, square_0, square_1))

    return exact, look_up


def lift_limits(lifting: Lifting, law: Law) -> tuple[Any, Any]:
    """Return what prepares the commands at the limits of the clamp, and the inverse that takes them from there."""
    width, compiled, count = lifting
    (exact, _), at_limits, (low, high) = lift_lookup(lifting), ROW["at_limits"], law_rows(law)[1][-2:]

    @compiled
    def limits(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(s, at_limits * width + i, exact(s, i, peek(s, low * width + i)))
            poke(s, (at_limits + 1) * width + i, exact(s, i, peek(s, high * width + i)))

    @compiled
    def exact_or_limit(s, i, u):  # type: ignore[no-untyped-def]
        if u == peek(s, low * width + i):
            return peek(s, at_limits * width + i)
        if u == peek(s, high * width + i):
            return peek(s, (at_limits + 1) * width + i)
        return exact(s, i, u)

    return limits, exact_or_limit


def lift_overdrive(lifting: Lifting) -> Any:
    """Return what lets the amplitude command overshoot; with gains that believe in no lag it changes nothing."""
    width, compiled, count = lifting
    command, believed, drive_rows = ROW["command"], ROW["overdrive"], OverdriveGains(*rows("overdrive_gains"))

    @compiled
    def overdrive(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            gains = load(s, i, width, drive_rows)
            a, c = overdrive_step(peek(s, believed * width + i), peek(s, command * width + i), gains)
            poke(s, believed * width + i, a)
            poke(s, command * width + i, c)

    return overdrive
