"""What is told of each control period: the traces that a run records, and the tallies that metrics are made of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from frictionloop.loop.kernel.slab import ROW, ROWS
from frictionloop.loop.kernel.slab_access import doubles, load, store
from frictionloop.loop.kernel.step_lifting import Lifting
from frictionloop.loop.kernel.tile_compatibility import effect_of, kernel_of
from frictionloop.loop.metric import Sample, Tally
from frictionloop.loop.metrics import TALLIES
from frictionloop.parameters import System
from frictionloop.quantities import flat_tuples

TRACES = ("f_r", "f_a", "f_m", "u", "a", "d", "saturated")
BENCH_TRACES = (*TRACES, "position", "speed", "load", "limit", "floor", "sliding", "scored")
"""Traces of the two kernels, in the order of their rows."""
_SIGNALS = (
    *(ROW["setpoint"], ROW["friction"], ROW["measurement"].force),
    *(ROW[name] for name in ("u", "amplitude", "disturbance", "saturated")),
)
"""Rows of the first of them; f_a is friction and disturbance."""
_REACH = *ROW["motion"][:3], ROW["nominal"], ROW["floor"]
_VALID = ROW["measurement"].valid
_BENCH_ROWS = *_REACH, _VALID, ROW["scored"]


def traces_of(system: System) -> tuple[str, ...]:
    """Return the names of the traces that the kernel of a system records."""
    if kernel_of(system) == "quadrature":
        return TRACES
    return (*BENCH_TRACES, "f_r_intended") if effect_of(system) else BENCH_TRACES


def build_record(lifting: Lifting, kernel: str) -> Any:
    """Return the tile that writes the traces of one period, ``[trace][period][lane]``."""
    width, compiled, count = lifting
    numbers = tuple(range(len(BENCH_TRACES)))
    first, others, more = numbers[: len(TRACES)], numbers[len(TRACES) :], kernel != "quadrature"
    effect, last, intended = kernel == "effect", len(BENCH_TRACES), ROW["intended"]

    @compiled
    def record(s, n, k, at, o):  # type: ignore[no-untyped-def]
        out, size = doubles(o.trace), o.trace_size
        for i in range(count(n)):
            f_r, friction, f_m, u, a, d, saturated = load(s, i, width, _SIGNALS)
            store(out, k * width + i, size, first, (f_r, friction + d, f_m, u, a, d, saturated))
            if more:
                store(out, k * width + i, size, others, load(s, i, width, _BENCH_ROWS))
            if effect:
                store(out, k * width + i, size, last, load(s, i, width, intended))

    return record


def places_of(tallies: Sequence[Tally]) -> tuple[dict[Tally, int], int]:
    """Return the first row of each tally: periods that counted, then its state; and the row after the last.

    Those of this package have a place whether they are asked for or not: a tally is then compiled for one place.
    """
    places, after = {}, ROWS
    for tally in dict.fromkeys((*TALLIES, *tallies)):
        places[tally], after = after, after + 1 + flat_tuples.size(tally.state)
    return {tally: places[tally] for tally in dict.fromkeys(tallies)}, after


def build_tally(lifting: Lifting, tally: Tally, first: int) -> Any:
    """Lift a tally's step over the periods that count, or over all."""
    width, compiled, count = lifting
    step, everywhere, inside = tally.step, tally.everywhere, ROW["scored"]
    state_rows = flat_tuples.shaped(tally.state, range(first + 1, first + 1 + flat_tuples.size(tally.state)))

    @compiled
    def update(s, n, k, at, o):  # type: ignore[no-untyped-def]
        counting = 1.0 if k >= o.score_from else 0.0
        if everywhere or counting > 0.0:
            for i in range(count(n)):
                f_r, friction, f_m, u, a, d, saturated = load(s, i, width, _SIGNALS)
                x, v, pressed, limit, floor = load(s, i, width, _REACH)
                scored = load(s, i, width, inside)
                counts = scored * counting
                f_a, valid = friction + d, load(s, i, width, _VALID)
                sample = Sample(f_r, f_a, f_m, u, a, d, saturated, x, v, pressed, limit, floor, scored, counts, valid)
                store(s, i, width, first, load(s, i, width, first) + counts)
                if everywhere or counts > 0.0:
                    store(s, i, width, state_rows, step(load(s, i, width, state_rows), sample, o.dt))

    return update
