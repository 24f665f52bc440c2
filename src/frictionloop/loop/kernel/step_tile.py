"""The tile of step responses: when the force has gone 10, 63 and 90 % of the way after each step of the set-point."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import load, peek, poke, store
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import fma, step


@step
def follow_step(
    from_n: float, to_n: float, since: float, at_10: float, at_63: float, done: float, setpoint_n: float, force_n: float
) -> tuple[tuple[float, float, float, float, float, float], float]:
    """Times, in control periods since the step, of the first passage of 10 and 63 %; and 1 at that of 90 %, else 0.

    A set-point that changes begins a new step; one that has not got to 90 % by then is not counted, nor one
    that had before it was asked to.
    """
    stepped = setpoint_n != to_n
    from_n = to_n if stepped else from_n
    since = 0.0 if stepped else since + 1.0
    at_10, at_63 = -1.0 if stepped else at_10, -1.0 if stepped else at_63
    way = (force_n - from_n) * (1.0 if setpoint_n > from_n else -1.0)
    whole = abs(setpoint_n - from_n)
    # A force that is there already has not followed.
    done = (1.0 if way >= 0.9 * whole else 0.0) if stepped else done
    at_10 = since if (at_10 < 0.0) & (way >= 0.1 * whole) else at_10
    at_63 = since if (at_63 < 0.0) & (way >= 0.632 * whole) else at_63
    arrived = 1.0 if (done == 0.0) & (way >= 0.9 * whole) else 0.0
    return (from_n, setpoint_n, since, at_10, at_63, max(done, arrived)), arrived


def build_steps(lifting: Lifting) -> Any:
    """Lift the passages and the sums of their times, apart for steps up and down.

    Steps that a reversal or a lift-off interrupts are not counted.
    """
    width, compiled, count = lifting
    state_rows, sums, scored = rows("step"), ROW["step_sums"], ROW["scored"]
    g_row, d_row, r_row = ROW["friction"], ROW["disturbance"], ROW["setpoint"]

    @compiled
    def begin(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            r = peek(s, r_row * width + i)
            store(s, i, width, state_rows, (r, r, 0.0, 0.0, 0.0, 1.0))

    @compiled
    def passages(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if k == 0:
            begin(s, n)
        counts = k >= o.score_from
        for i in range(count(n)):
            force = peek(s, g_row * width + i) + peek(s, d_row * width + i)
            given = load(s, i, width, state_rows)
            (low, high, since, at_10, at_63, done), arrived = follow_step(*given, peek(s, r_row * width + i), force)
            inside = peek(s, scored * width + i)
            store(s, i, width, state_rows, (low, high, since, at_10, at_63, max(done, 1.0 - inside)))
            weight = arrived * inside if counts else 0.0
            up = weight if high > low else 0.0
            rise = since - at_10
            add(s, i, 0, up, at_63, rise)
            add(s, i, 5, weight - up, at_63, rise)

    @compiled
    def add(s, i, first, weight, at_63, rise):  # type: ignore[no-untyped-def]
        base = (sums + first) * width + i
        poke(s, base, peek(s, base) + weight)
        poke(s, base + width, fma(weight, at_63, peek(s, base + width)))
        poke(s, base + 2 * width, fma(weight, at_63 * at_63, peek(s, base + 2 * width)))
        poke(s, base + 3 * width, fma(weight, rise, peek(s, base + 3 * width)))
        poke(s, base + 4 * width, fma(weight, rise * rise, peek(s, base + 4 * width)))

    return passages
