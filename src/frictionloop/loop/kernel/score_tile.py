"""The tile of streaming metrics: sums over the scored periods, so that memory does not grow with duration."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import peek, poke
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import fma

IDENTITY, SATURATION, REGRESSION, BOUND, PERCEPTION, STEPS = 1, 2, 4, 8, 16, 32
"""Groups of streaming sums a run may ask for, as bits."""


def build_scores(lifting: Lifting) -> Any:
    """Return the tile that sums over the scored periods of a bench."""
    scores = lift_scores(lifting, masked=True)

    @lifting.compiled
    def score(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if k >= o.score_from:
            scores(s, n, o.groups)

    return score


def lift_scores(lifting: Lifting, masked: bool = False) -> Any:
    """Lift the streaming sums of the metrics (loop/formulas.py turns them into numbers).

    ``masked`` kernels count only periods whose ``scored`` row is 1, and how many there are.
    """
    width, compiled, count = lifting
    sums, shift = ROW["sums"], ROW["shift"]
    r_row, g_row, d_row, sat = ROW["setpoint"], ROW["friction"], ROW["disturbance"], ROW["saturated"]
    floor, nominal, scored = ROW["floor"], ROW["nominal"], ROW["scored"]

    @compiled
    def add(s, i, row, x, y):  # type: ignore[no-untyped-def]
        if masked:
            x = x * peek(s, scored * width + i)
        poke(s, (sums + row) * width + i, fma(x, y, peek(s, (sums + row) * width + i)))

    @compiled
    def scores(s, n, groups):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            r = peek(s, r_row * width + i)
            error = peek(s, g_row * width + i) + peek(s, d_row * width + i) - r
            r = r - peek(s, shift * width + i)
            add(s, i, 0, error, error)
            add(s, i, 1, r, 1.0)
            add(s, i, 2, r, r)
            if masked:
                add(s, i, 8, 1.0, 1.0)
        if groups & SATURATION:
            for i in range(count(n)):
                add(s, i, 3, peek(s, sat * width + i), 1.0)
        if groups & REGRESSION:
            for i in range(count(n)):
                f = peek(s, g_row * width + i) + peek(s, d_row * width + i) - peek(s, shift * width + i)
                add(s, i, 4, f, 1.0)
                add(s, i, 5, f, f)
                add(s, i, 6, f, peek(s, r_row * width + i) - peek(s, shift * width + i))
        if groups & BOUND:
            for i in range(count(n)):
                r, d = peek(s, r_row * width + i), peek(s, d_row * width + i)
                best = min(max(r, peek(s, floor * width + i) + d), peek(s, nominal * width + i) + d)
                add(s, i, 7, best - r, best - r)

    return scores
