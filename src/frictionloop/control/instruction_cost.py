"""What a control law costs a tick on the board: instructions, counted on its emulated image.

No model of a Cortex-M7's cycles is known. An instruction takes at most `CYCLES_AT_MOST` (assumed); the board's own
counter decides, which `device info` shows.
"""

from __future__ import annotations

CORE_HZ = 396_000_000
"""Of the board (firmware/boards/teensy41/teensy41.h)."""
CYCLES_AT_MOST = 20
"""Of an instruction, on average over a tick (assumed; a division of doubles takes about as many)."""
BEYOND = 4.0
"""Times the highest rate by that bound above which an image is refused (assumed: 5 cycles an instruction)."""


def highest_rate_hz(instructions: int) -> float:
    """Return the rate at which ticks of so many instructions fill a board's time, at `CYCLES_AT_MOST` each."""
    return CORE_HZ / (CYCLES_AT_MOST * instructions)


WORST_TICK = {"pi": 1781, "lookup": 1601, "notch_pi": 2210, "filtered_pi": 2210, "limit_observer": 2167}
"""Most instructions of a tick by kind of controller, from entry to return of its interrupt.

On the image of bench() with two force axes, with zig 0.17.1, over 400 samples each of a finger that strokes at 20 and
80 mm/s, and of edges; `frictionloop firmware build` counts so, and tests/firmware/test_instructions.py holds it. The
filtered PIs have all they can: feed-forward, overdrive, 6 sections, of which one costs as much.
"""


def worst_tick(kind: str) -> int | None:
    """Return the most instructions of a tick with a kind of controller, None of one that has no image."""
    return WORST_TICK.get(kind)
