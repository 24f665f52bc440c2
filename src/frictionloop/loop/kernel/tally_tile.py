"""The tile of a tally, and where in a slab tallies are kept."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from frictionloop.loop.kernel.access import load, peek, poke, store
from frictionloop.loop.kernel.slab import ROW, ROWS, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.loop.metric import Sample, Tally
from frictionloop.loop.tallies import TALLIES
from frictionloop.quantities import trees


def places_of(tallies: Sequence[Tally]) -> tuple[dict[Tally, int], int]:
    """Return the first row of each tally: periods that counted, then its state; and the row after the last.

    Those of this package have a place whether they are asked for or not: a tally is then compiled for one place.
    """
    places, after = {}, ROWS
    for tally in dict.fromkeys((*TALLIES, *tallies)):
        places[tally], after = after, after + 1 + trees.size(tally.state)
    return {tally: places[tally] for tally in dict.fromkeys(tallies)}, after


def build_tally(lifting: Lifting, tally: Tally, first: int) -> Any:
    """Lift a tally's step over the periods that count, or over all."""
    width, compiled, count = lifting
    step, everywhere = tally.step, tally.everywhere
    state_rows = trees.shaped(tally.state, range(first + 1, first + 1 + trees.size(tally.state)))
    signals = "setpoint", "friction", "measurement", "u", "amplitude", "disturbance", "saturated"
    limits = "nominal", "floor", "scored", "scored"
    given = Sample._make((*(ROW[name] for name in signals), *rows("motion")[:3], *(ROW[name] for name in limits)))

    @compiled
    def update(s, n, k, at, o):  # type: ignore[no-untyped-def]
        counting = 1.0 if k >= o.score_from else 0.0
        if everywhere or counting > 0.0:
            for i in range(count(n)):
                f_r, g, f_m, u, a, d, saturated, x, v, pressed, limit, floor, inside, _ = load(s, i, width, given)
                counts = inside * counting
                sample = Sample(f_r, g + d, f_m, u, a, d, saturated, x, v, pressed, limit, floor, inside, counts)
                poke(s, first * width + i, peek(s, first * width + i) + counts)
                if everywhere or counts > 0.0:
                    store(s, i, width, state_rows, step(load(s, i, width, state_rows), sample, o.dt))

    return update
