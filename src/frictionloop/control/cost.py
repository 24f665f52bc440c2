"""What a control law costs a tick on a Cortex-M4, traced on its image.

The whole tick counts: sampling, touch, law, lookup, limits, telemetry, with every line of the flash a miss.
"""

from __future__ import annotations

from typing import NamedTuple

BUDGET_CYCLES = 14_400
"""Cycles of a tick: 72 MHz over 5 kHz."""
LATE_CYCLES = 720
"""How late a tick may begin: 10 us (firmware/boards/teensy31/board.c, LATE_COUNTS)."""


class WorstTick(NamedTuple):
    """The most that any tick took, with an upper bound for every instruction (device/emulator/trace.py)."""

    instructions: int
    cycles: int


WORST_TICK = {
    "pi": WorstTick(1818, 3396),
    "lookup": WorstTick(1798, 3327),
    "notch_pi": WorstTick(2626, 4519),
    "filtered_pi": WorstTick(3539, 5732),
    "limit_observer": WorstTick(2442, 4715),
}
"""By kind of controller, on the image of bench() with two force axes, from entry to return of the tick's interrupt.

With zig 0.17.1, over 400 samples each of a finger that strokes at 20 and 80 mm/s, and of edges; `frictionloop firmware
build` traces so, and tests/firmware/test_cycles.py holds it. The filtered PIs have all they can: feed-forward,
overdrive, 1 section (notch) or 6.
"""


def worst_tick(kind: str) -> WorstTick | None:
    """Return what the worst tick of a kind of controller takes, None of one that has no image."""
    return WORST_TICK.get(kind)
