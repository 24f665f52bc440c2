"""Cycles of an instruction of the Cortex-M4, by class: the worst that its manual allows.

Cortex-M4 Technical Reference Manual, ARM DDI 0439, table of instructions. P, the refill of the pipeline after a
jump, is 1 to 3 cycles: 3 here. Loads and stores are 1 or 2: 2 here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

REFILL = 3
"""P: of the pipeline, wherever the next instruction is not the one that follows."""
EXCEPTION = 24
"""Entry and return of an interrupt, 12 each (the same manual)."""
LINE_BYTES, WORD_BYTES = 8, 4
"""What the flash and the RAM give at a time."""


class Waits(NamedTuple):
    """Cycles that the processor waits beyond those of its instructions: assumed, none was measured."""

    next_line: float
    """For a line of instructions from the flash that follows the last one."""
    other_line: float
    """For any other line."""
    flash_data: float
    """For data from the flash."""
    ram_word: float
    """For a word of instructions from the RAM."""
    peripheral: float
    """For an access to a peripheral."""


ASSUMED = Waits(2, 3, 3, 0, 6)
"""The flash at 24 MHz is three cycles of 72 MHz (clock.c sets it; K20P64M72SF1RM allows 25 MHz). Every line is a
miss of its cache, which the manual describes and no model here has: an upper bound. The lower half of the RAM is on the
code bus and does not wait (same manual, SRAM_L). The bridge to the peripherals runs at half the clock."""
OTHERWISE = {
    "as assumed": ASSUMED,
    "flash never waits": ASSUMED._replace(next_line=0, other_line=0, flash_data=0),
    "flash waits twice": ASSUMED._replace(next_line=4, other_line=6, flash_data=6),
    "RAM waits a cycle": ASSUMED._replace(ram_word=1),
    "peripherals wait twice": ASSUMED._replace(peripheral=12),
}
"""What being wrong about one of them means."""

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
