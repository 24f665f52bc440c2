"""How many instructions and cycles an image takes, in its tick, its port's interrupts and its background.

Cycles are the worst that the manual allows, by class: Cortex-M4 Technical Reference Manual, ARM DDI 0439, table of
instructions. P, the refill of the pipeline after a jump, is 1 to 3 cycles: 3 here. Loads and stores are 1 or 2: 2 here.
"""

from __future__ import annotations

from operator import add
from typing import Any, NamedTuple

from frictionloop.device.emulator.registers import FLASH, RAM
from frictionloop.device.emulator.teensy import BACKGROUND, TICK, TeensyEmulator
from frictionloop.firmware.image_files import FLASH_BYTES
from frictionloop.quantities.extra import needed

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


class Spent(NamedTuple):
    """What a stretch of the image took: instructions, their cycles without waiting, and what it waits for."""

    instructions: int
    core: int
    next_lines: int
    other_lines: int
    flash_reads: int
    ram_words: int
    peripheral_accesses: int

    @property
    def cycles(self) -> int:
        """Cycles at most, with `ASSUMED`."""
        return round(self.under(ASSUMED))

    def under(self, waits: Waits) -> float:
        """Return the cycles with these waits."""
        return self.core + sum(a * b for a, b in zip(waits, self[2:], strict=True))

    def plus(self, other: Spent) -> Spent:
        """Return both together."""
        return Spent(*map(add, self, other))


NOTHING = Spent(0, 0, 0, 0, 0, 0, 0)


class _Block(NamedTuple):
    """Instructions one after the other: how many, their cycles, the lines and words they take, and where they end."""

    instructions: int
    cycles: int
    first_line: int
    last_line: int
    words: int
    end: int


class CycleTrace:
    """Counts the instructions of the image and what they cost; of the tick's interrupt from entry to return.

    Every block of instructions is taken apart once (capstone), and costed by `costs`. An interrupt of the port that
    comes during a tick on a board comes here after it.
    """

    def __init__(self, emulator: TeensyEmulator) -> None:
        unicorn = needed("unicorn", "unicorn", "emulator")
        capstone = needed("capstone", "capstone", "emulator")
        self._disassembler = capstone.Cs(capstone.CS_ARCH_ARM, capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS)
        self._emulator, self._uc = emulator, emulator.processor.uc
        self._blocks: dict[tuple[int, int], _Block] = {}
        self._count: list[int] = list(NOTHING)
        self._last: _Block | None = None
        self._counts: list[tuple[str, list[int]]] = []
        uc = self._uc
        uc.hook_add(unicorn.UC_HOOK_BLOCK, self._block)
        uc.hook_add(unicorn.UC_HOOK_MEM_READ, self._read, None, FLASH, FLASH + FLASH_BYTES - 1)
        uc.ctl_flush_tb()
        emulator.processor.on_access = self._access
        emulator.on_enter = self._enter

    def tick(self, force_counts: tuple[int, int], load_counts: int, position: int) -> Spent:
        """Run a tick as `TeensyEmulator.tick` does, and return what its interrupt took."""
        return self.parts(force_counts, load_counts, position)[TICK][0]

    def parts(self, force_counts: tuple[int, int], load_counts: int, position: int) -> dict[str, list[Spent]]:
        """Run a tick, and return what each interrupt took, and each stretch of the background, by what it was."""
        self._counts = []
        self._emulator.tick(force_counts, load_counts, position)
        found: dict[str, list[Spent]] = {}
        for what, count in self._counts:
            found.setdefault(what, []).append(Spent(*count))
        return found

    def _enter(self, what: str) -> None:
        self._count, self._last = list(NOTHING), None
        self._count[1] = EXCEPTION if what != BACKGROUND else 0
        self._counts.append((what, self._count))

    def _block(self, uc: Any, address: int, size: int, _: Any) -> None:
        block = self._blocks.get((address, size)) or self._take_apart(address, size)
        last, count = self._last, self._count
        count[0] += block.instructions
        count[1] += block.cycles + (REFILL if last is None or last.end != address else 0)
        if address < RAM:
            count[2] += block.last_line - block.first_line
            if last is None or block.first_line != last.last_line:
                count[2 if last and block.first_line == last.last_line + 1 else 3] += 1
        else:
            count[5] += block.words
        self._last = block

    def _take_apart(self, address: int, size: int) -> _Block:
        instructions = list(self._disassembler.disasm(bytes(self._uc.mem_read(address, size)), address))
        if sum(instruction.size for instruction in instructions) != size:
            raise ValueError(f"0x{address:x}: {size} bytes that are no instructions")
        first, last = address // LINE_BYTES, (address + size - 1) // LINE_BYTES
        words = (address + size - 1) // WORD_BYTES - address // WORD_BYTES + 1
        total = sum(cycles(instruction) for instruction in instructions)
        block = self._blocks[address, size] = _Block(len(instructions), total, first, last, words, address + size)
        return block

    def _read(self, uc: Any, access: int, address: int, size: int, value: int, _: Any) -> None:
        self._count[4] += 1

    def _access(self) -> None:
        self._count[6] += 1
