"""What a control law costs a tick on a Cortex-M7: instructions of its image, counted in an emulator.

No cycle model of a Cortex-M7 is public: `CYCLES` bound an instruction, and a board's own counter decides.
"""

from __future__ import annotations

CORE_HZ = 396e6
"""Clock of the board's processor, as its ROM leaves it."""
CYCLES = 20
"""Cycles of an instruction at most (assumed): a miss of the flash, or a division of doubles."""
BEYOND = 4
"""A rate is refused from so many times the highest on that no counter of a board could make it right."""
WORST_TICK = {"pi": 1381, "lookup": 1143, "notch_pi": 1825, "filtered_pi": 1825, "limit_observer": 1742}
"""Instructions of the worst tick by kind of controller, on the image of bench() with two force axes.

With zig 0.17.1; `frictionloop firmware build` counts so, and tests/firmware/test_instructions.py holds it. The filtered PIs
have all they can: feed-forward, overdrive, 6 sections, which cost as much where they let everything through.
"""


def worst_tick(kind: str) -> int | None:
    """Return the instructions of the worst tick of a kind of controller; None of one from outside."""
    return WORST_TICK.get(kind)


def highest_hz(instructions: int) -> float:
    """Return the highest rate of ticks that `CYCLES` for each instruction allow."""
    return CORE_HZ / (CYCLES * instructions)
