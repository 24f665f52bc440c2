"""What the worst tick of each law takes on the image of bench(): traced, and held by tests/firmware/test_cycles.py."""

from __future__ import annotations

from typing import NamedTuple

TICK_CYCLES = 14_400
"""Cycles of a tick: 72 MHz over 5 kHz."""


class WorstTick(NamedTuple):
    """The most that any tick took, with an upper bound for every instruction (`costs`)."""

    instructions: int
    cycles: int


WORST_TICK = {
    "pi": WorstTick(1358, 2466),
    "lookup": WorstTick(1339, 2402),
    "notch_pi": WorstTick(2166, 3589),
    "observer": WorstTick(1766, 3399),
    "super_twisting": WorstTick(1951, 3767),
    "tracker": WorstTick(3503, 7191),
}
"""By kind of controller: from entry to return of the tick's interrupt, with zig 0.17.1, over 400 samples of a finger
that strokes and of edges; 1500 have no worse."""
SAME_LAW = {"filtered_pi": "notch_pi"}
"""A kind that runs the same C as another; only gains differ."""


def worst_tick(kind: str) -> WorstTick | None:
    """Return what the worst tick of a kind of controller takes, None for one that was not traced."""
    return WORST_TICK.get(SAME_LAW.get(kind, kind))
