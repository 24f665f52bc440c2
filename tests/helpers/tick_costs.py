"""Cycles of an instruction of the Cortex-M4, by class: the worst that its manual allows.

Cortex-M4 Technical Reference Manual, ARM DDI 0439, table of instructions. P, the refill of the pipeline after a
jump, is 1 to 3 cycles: 3 here. Loads and stores are 1 or 2: 2 here.
"""

from __future__ import annotations

from typing import Any

REFILL = 3
"""P: of the pipeline, wherever the next instruction is not the one that follows."""
EXCEPTION = 24
"""Entry and return of an interrupt, 12 each (the same manual)."""
LINE_BYTES, NEXT_LINE, OTHER_LINE, FLASH_DATA = 8, 2, 3, 3
"""Flash at 24 MHz without its cache: cycles that a new line of instructions costs when it follows the last and when it
does not, and that reading data from flash costs. Every line is taken as a miss, so this is an upper bound."""
PERIPHERAL = 6
"""Cycles that an access to a peripheral takes beyond those of the load or store (assumed: the bridge to a bus at half
the clock)."""

_CYCLES = {
    "mla": 2, "mls": 2, "sdiv": 12, "udiv": 12, "mrs": 2, "msr": 2, "cps": 2, "dsb": 5, "dmb": 5, "isb": 5, "tbb": 2,
    "tbh": 2,
}  # fmt: skip
_MANY = ("ldm", "stm", "push", "pop", "vpush", "vpop")
_DOUBLE = ("ldrd", "strd")
_FLOAT = "v"


def cycles(instruction: Any) -> int:
    """Return the cycles of an instruction of capstone; a jump's refill comes on top where it jumps.

    Raises
    ------
    ValueError
        For an instruction of the floating-point unit, which the processor has not.
    """
    name = instruction.insn_name()
    if name.startswith(_FLOAT):
        place = f"{instruction.mnemonic} at 0x{instruction.address:x}"
        raise ValueError(f"{place}: the MK20DX256 has no floating-point unit")
    if name.startswith(_MANY):
        registers = instruction.op_str[instruction.op_str.index("{") :].count(",") + 1
        return 1 + registers
    if name.startswith(_DOUBLE):
        return 3
    if name.startswith(("ldr", "str")):
        return 2
    return _CYCLES.get(name, 1)
