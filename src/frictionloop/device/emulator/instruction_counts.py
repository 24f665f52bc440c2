"""How many instructions an image takes: in its tick and the law in it, in its port's interrupts, in its background."""

from __future__ import annotations

import struct
from typing import Any, NamedTuple

from frictionloop.device.emulator.teensy import TICK, TeensyEmulator
from frictionloop.firmware.image_files import addresses
from frictionloop.quantities.optional_libraries import needed

LAW = ("fl_own_step", "fl_open_step", "fl_look_up", "fl_overdrive")
"""Functions of an image that are the law, and what stands behind every law."""


class Spent(NamedTuple):
    """Instructions that a stretch of the image took, and those of them in the law."""

    instructions: int
    law: int


def count(code: bytes) -> int:
    """Return how many instructions code has: one of 32 bits begins with 0b11101, 0b11110 or 0b11111 (ARMv7-M A5.1)."""
    halves, place, found = struct.unpack(f"<{len(code) // 2}H", code), 0, 0
    while place < len(halves):
        place += 2 if halves[place] >> 11 in {0b11101, 0b11110, 0b11111} else 1
        found += 1
    return found


class InstructionTrace:
    """Counts the instructions that an emulated image issues, those that a condition passes over among them.

    An interrupt of the port that comes during a tick on a board comes here after it.
    """

    def __init__(self, emulator: TeensyEmulator) -> None:
        unicorn = needed("unicorn", "unicorn", "emulator")
        processor = emulator.processor
        self._arm, self._uc, self._emulator = processor.arm, processor.uc, emulator
        self._law = frozenset(place & ~1 for place in addresses(processor.image, LAW).values())
        self._blocks: dict[tuple[int, int], int] = {}
        self._total = self._in_law = 0
        self._back: int | None = None
        self._stretches: list[tuple[str, int, int]] = []
        self._uc.hook_add(unicorn.UC_HOOK_BLOCK, self._block)
        self._uc.ctl_flush_tb()
        emulator.on_enter = self._enter

    def tick(self, force_counts: tuple[int, int], load_counts: int, position: int) -> Spent:
        """Run a tick as `TeensyEmulator.tick` does, and return what its interrupt took."""
        return self.parts(force_counts, load_counts, position)[TICK][0]

    def parts(self, force_counts: tuple[int, int], load_counts: int, position: int) -> dict[str, list[Spent]]:
        """Run a tick, and return what each interrupt took, and each stretch of the background, by what it was."""
        self._stretches = []
        self._emulator.tick(force_counts, load_counts, position)
        self._enter("")
        found: dict[str, list[Spent]] = {}
        for (what, total, law), (_, after, law_after) in zip(self._stretches, self._stretches[1:], strict=False):
            found.setdefault(what, []).append(Spent(after - total, law_after - law))
        return found

    def _enter(self, what: str) -> None:
        self._back = None
        self._stretches.append((what, self._total, self._in_law))

    def _block(self, uc: Any, address: int, size: int, _: Any) -> None:
        """Take a block of instructions; of the law is what runs from the begin of a function of it to its return."""
        found = self._blocks.get((address, size))
        if found is None:
            found = self._blocks[address, size] = count(bytes(uc.mem_read(address, size)))
        if self._back is None and address in self._law:
            self._back = uc.reg_read(self._arm.UC_ARM_REG_LR) & ~1
        elif address == self._back:
            self._back = None
        self._total += found
        if self._back is not None:
            self._in_law += found
