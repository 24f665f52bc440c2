"""What a control law costs a tick on a Cortex-M4 in Q31, estimated from its operations.

It is of the law alone and without waits for the flash, and ranks laws before there is an image. The whole tick, traced
on the image (device/emulator/budget), takes four times that with the tracker and twenty times with the lookup.
"""

from __future__ import annotations

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
