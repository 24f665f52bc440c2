"""What a control law costs a tick on a Cortex-M4: traced on its image, and estimated in Q31 from its operations.

Traced is the whole tick: sampling, touch, law, lookup, limits, telemetry, with every line of the flash a miss. The
estimate is of the law alone and without waits for the flash; it ranks laws before there is an image.
"""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.control.law import Operations

BUDGET_CYCLES = 14_400
"""Cycles of a tick: 72 MHz over 5 kHz."""
CYCLES_M4 = Operations(
    multiplications=4,
    additions=2,
    comparisons=3,
    divisions=30,
    roots=60,
    exponentials=45,
    logarithms=45,
    lookups=115,
)
"""Cycles of each operation in Q31 with zero wait states.

Documented (Arm Cortex-M4 Technical Reference Manual, table 3-1): SMULL, SMMUL, SMMLA, ADD, QADD, CMP 1, LDR 2 (1 if
pipelined), SDIV 2 to 12, SSAT 1. Assumed on top: a multiplication loads an operand and scales; an addition loads one;
a comparison has an IT block; a division scales both sides to the full 32 bits; a root is three Newton steps from a
table; 2^x and log2 take a table and a polynomial of order 3; a lookup is a logarithm, a product and a root.
"""


def cycles_m4(operations: Operations) -> int:
    """Return sum_i n_i c_i, cycles a tick on a Cortex-M4 in Q31, without interrupt entry and the drivers.

    Parameters
    ----------
    operations
        Of a law (``Law.operations``). A multiplication and an addition that a core fuses count as both, so the estimate
        is rather high.
    """
    return int(sum(count * cost for count, cost in zip(operations, CYCLES_M4, strict=True)))


class WorstTick(NamedTuple):
    """The most that any tick took, with an upper bound for every instruction (device/emulator/costs)."""

    instructions: int
    cycles: int


WORST_TICK = {
    "pi": WorstTick(1353, 2472),
    "lookup": WorstTick(1331, 2403),
    "notch_pi": WorstTick(2161, 3595),
    "filtered_pi": WorstTick(3074, 4808),
    "observer": WorstTick(1758, 3398),
    "super_twisting": WorstTick(1943, 3766),
    "tracker": WorstTick(3501, 7169),
}
"""By kind of controller, on the image of bench(), from entry to return of the tick's interrupt.

With zig 0.17.1, over 400 samples each of a finger that strokes at 20 and 80 mm/s, and of edges; held by
tests/firmware/test_cycles.py. Four seeds, and 2600 samples at either speed, have no worse of the tracker and the notch
PI. The filtered PIs have all they can: feed-forward, overdrive, 1 section (notch) or 6.
"""


def worst_tick(kind: str) -> WorstTick | None:
    """Return what the worst tick of a kind of controller takes, None of one that has no image: an oracle."""
    return WORST_TICK.get(kind)
