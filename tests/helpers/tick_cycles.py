"""How many instructions and cycles a tick of an image takes, from a trace of it."""

from __future__ import annotations

from typing import Any, NamedTuple

from tick_costs import (
    EXCEPTION,
    FLASH_DATA,
    LINE_BYTES,
    NEXT_LINE,
    OTHER_LINE,
    PERIPHERAL,
    REFILL,
    cycles,
)

from frictionloop.device.emulator.memory_map import FLASH, FLASH_BYTES, RAM
from frictionloop.device.emulator.teensy import TeensyEmulator
from frictionloop.quantities.extra import needed


class TickCost(NamedTuple):
    """What a tick took: instructions, cycles at most, and what these are made of besides instructions."""

    instructions: int
    cycles: int
    flash_reads: int
    peripheral_accesses: int


class _Block(NamedTuple):
    """Instructions one after the other: how many, their cycles with the lines they begin, and where they end."""

    instructions: int
    cycles: int
    first_line: int
    last_line: int
    end: int


class CycleTrace:
    """Counts the instructions of the tick's interrupt and what they cost, from entry to return.

    Every block of instructions is taken apart once (capstone), and costed by `costs`. Interrupts of the port that come
    during a tick on a board do not come here.

    Parameters
    ----------
    emulator
        The board that runs; its ticks are slower from now on.
    """

    def __init__(self, emulator: TeensyEmulator) -> None:
        unicorn = needed("unicorn", "unicorn", "emulator")
        capstone = needed("capstone", "capstone", "emulator")
        self._disassembler = capstone.Cs(capstone.CS_ARCH_ARM, capstone.CS_MODE_THUMB | capstone.CS_MODE_MCLASS)
        self._emulator, self._uc = emulator, emulator.processor.uc
        self._blocks: dict[tuple[int, int], _Block] = {}
        self._count: list[int] = [0, 0, 0, 0]
        self._last: _Block | None = None
        uc = self._uc
        uc.hook_add(unicorn.UC_HOOK_BLOCK, self._block)
        uc.hook_add(unicorn.UC_HOOK_MEM_READ, self._read, None, FLASH, FLASH + FLASH_BYTES - 1)
        uc.ctl_flush_tb()
        emulator.processor.on_access = self._access

    def tick(self, force_counts: tuple[int, int], load_counts: int, position: int) -> TickCost:
        """Run a tick as `TeensyEmulator.tick` does, and return what it took."""
        self._count, self._last = [0, EXCEPTION, 0, 0], None
        self._emulator.tick(force_counts, load_counts, position)
        count = self._count
        return TickCost(count[0], count[1] + FLASH_DATA * count[2] + PERIPHERAL * count[3], count[2], count[3])

    def _block(self, uc: Any, address: int, size: int, _: Any) -> None:
        if not self._emulator.in_tick:
            return
        block = self._blocks.get((address, size)) or self._take_apart(address, size)
        last, more = self._last, 0
        if address < RAM and (last is None or block.first_line != last.last_line):
            more = NEXT_LINE if last and block.first_line == last.last_line + 1 else OTHER_LINE
        if last is None or last.end != address:
            more += REFILL
        self._count[0] += block.instructions
        self._count[1] += block.cycles + more
        self._last = block

    def _take_apart(self, address: int, size: int) -> _Block:
        instructions = list(self._disassembler.disasm(bytes(self._uc.mem_read(address, size)), address))
        if sum(instruction.size for instruction in instructions) != size:
            raise ValueError(f"0x{address:x}: {size} bytes that are no instructions")
        first, last = address // LINE_BYTES, (address + size - 1) // LINE_BYTES
        total = sum(cycles(instruction) for instruction in instructions)
        total += NEXT_LINE * (last - first) if address < RAM else 0  # the RAM does not keep it waiting
        block = self._blocks[address, size] = _Block(len(instructions), total, first, last, address + size)
        return block

    def _read(self, uc: Any, access: int, address: int, size: int, value: int, _: Any) -> None:
        if self._emulator.in_tick:
            self._count[2] += 1

    def _access(self) -> None:
        if self._emulator.in_tick:
            self._count[3] += 1
