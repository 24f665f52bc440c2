"""What a control law costs a tick on a Cortex-M4, traced on its image.

The whole tick counts: sampling, touch, law, lookup, limits, telemetry, with every line of the flash a miss.
"""

from __future__ import annotations

from typing import NamedTuple

BUDGET_CYCLES = 14_400
"""Cycles of a tick: 72 MHz over 5 kHz."""


class WorstTick(NamedTuple):
    """The most that any tick took, with an upper bound for every instruction (device/emulator/costs)."""

    instructions: int
    cycles: int


WORST_TICK = {
    "pi": WorstTick(1592, 3039),
    "lookup": WorstTick(1570, 2970),
    "notch_pi": WorstTick(2400, 4162),
    "filtered_pi": WorstTick(3313, 5375),
    "observer": WorstTick(1997, 3965),
    "super_twisting": WorstTick(2182, 4333),
    "tracker": WorstTick(3735, 7723),
}
"""By kind of controller, on the image of bench(), from entry to return of the tick's interrupt.

With zig 0.17.1, over 400 samples each of a finger that strokes at 20 and 80 mm/s, and of edges; held by
tests/firmware/test_cycles.py. Four seeds, and 2600 samples at either speed, have no worse of the tracker and the notch
PI. The filtered PIs have all they can: feed-forward, overdrive, 1 section (notch) or 6. The tracker, which is
experimental, takes more than the half of a tick that is left to a law that is recommended.
"""


def worst_tick(kind: str) -> WorstTick | None:
    """Return what the worst tick of a kind of controller takes, None of one that has no image: an oracle."""
    return WORST_TICK.get(kind)
