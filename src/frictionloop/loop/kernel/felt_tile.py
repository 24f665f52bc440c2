"""The tile of what is felt: the residual weighted by the thresholds of touch, whose mean square is the index D squared.

Where nothing is scored (reversals, lift-offs) the residual is faded out, and in again, over some 20 ms: cut off, it
would click in the filter.
"""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles, load, peek, poke
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import fma
from frictionloop.quantities.biquad import biquad_step

FADE_S = 0.01
"""Time constant of each of the two low-passes that fade the residual (assumed)."""


def build_felt(lifting: Lifting) -> Any:
    """Lift the fade and the weighting filter, one section after another, and the sum of squares."""
    width, compiled, count = lifting
    taper, percept, states, scored = ROW["taper"], ROW["percept"], ROW["percept_state"], ROW["scored"]
    g_row, d_row, r_row = ROW["friction"], ROW["disturbance"], ROW["setpoint"]

    @compiled
    def fade(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            gain, first = peek(s, taper * width + i), peek(s, (taper + 1) * width + i)
            second = peek(s, (taper + 2) * width + i)
            first = fma(gain, peek(s, scored * width + i) - first, first)
            second = fma(gain, first - second, second)
            poke(s, (taper + 1) * width + i, first)
            poke(s, (taper + 2) * width + i, second)
            error = peek(s, g_row * width + i) + peek(s, d_row * width + i) - peek(s, r_row * width + i)
            poke(s, percept * width + i, error * second)

    def section(j: int) -> Any:
        state, numbers = states + 2 * j, tuple(range(5 * j, 5 * j + 5))

        @compiled
        def filtered(s, n, c):  # type: ignore[no-untyped-def]
            b0, b1, b2, a1, a2 = load(c, 0, 1, numbers)
            for i in range(count(n)):
                s1, s2 = peek(s, state * width + i), peek(s, (state + 1) * width + i)
                s1, s2, y = biquad_step(s1, s2, peek(s, percept * width + i), b0, b1, b2, a1, a2)
                poke(s, state * width + i, s1)
                poke(s, (state + 1) * width + i, s2)
                poke(s, percept * width + i, y)

        return filtered

    first, second, third, fourth, fifth = (section(j) for j in range(5))

    @compiled
    def felt(s, n, k, at, o):  # type: ignore[no-untyped-def]
        coefficients = doubles(o.weighting)
        fade(s, n)
        first(s, n, coefficients)
        second(s, n, coefficients)
        third(s, n, coefficients)
        fourth(s, n, coefficients)
        fifth(s, n, coefficients)
        if k >= o.score_from:
            for i in range(count(n)):
                x = peek(s, percept * width + i) * peek(s, scored * width + i)
                poke(s, (percept + 1) * width + i, fma(x, x, peek(s, (percept + 1) * width + i)))

    return felt
