"""A Cortex-M4 in unicorn: memory, registers behind callbacks, reset, interrupts, rest."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path
from typing import Any

from frictionloop.device.elf import loaded
from frictionloop.device.emulator.bank import Bank
from frictionloop.device.emulator.memory_map import FLASH, FLASH_BYTES, PAGE, PAGES, RAM, RAM_BYTES
from frictionloop.device.extra import needed
from frictionloop.quantities import FrictionloopError

RETURN = 0x10000000
"""Where an interrupt returns to, an address without memory: unicorn does not know the hardware's 0xFFFFFFF9."""
HARD_FAULT = 3
THUMB = 1 << 24
LONGEST_US = 5_000_000
"""Of the host's time: a stretch of the image that takes longer has hung."""


class Processor:
    """Runs an image from its reset vector; interrupts come when they are asked for, and run to their end.

    Unicorn has no interrupt controller, so `interrupt` does what the hardware does: eight words on the stack, the vector,
    and back. The background runs until it waits for an interrupt (WFI).
    """

    def __init__(self, image_path: Path, bank: Bank) -> None:
        unicorn = needed("unicorn", "unicorn", "emulator")
        arm = self._arm = needed("unicorn.arm_const", "unicorn", "emulator")
        self._error, self._timed_out = unicorn.UcError, unicorn.UC_QUERY_TIMEOUT
        self.bank = bank
        self.failure: Exception | None = None
        uc = self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        uc.mem_map(FLASH, FLASH_BYTES, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        uc.mem_map(RAM, RAM_BYTES, unicorn.UC_PROT_ALL)
        for page in PAGES:
            uc.mmio_map(page, PAGE, self._read, page, self._write, page)
        for address, content in loaded(image_path):
            if address + len(content) > FLASH_BYTES:
                raise FrictionloopError(f"{image_path}: has {len(content)} bytes at 0x{address:08x}, outside the flash")
            uc.mem_write(address, content)
        self._frame = [
            getattr(arm, f"UC_ARM_REG_{name}") for name in ("R0", "R1", "R2", "R3", "R12", "LR", "PC", "XPSR")
        ]

    def vector(self, number: int) -> int:
        """Return an entry of the vector table."""
        return int.from_bytes(self.uc.mem_read(FLASH + 4 * number, 4), "little")

    def reset(self) -> None:
        """Begin as after power comes, and go on until the background first rests."""
        self.uc.reg_write(self._arm.UC_ARM_REG_SP, self.vector(0))
        self._run(self.vector(1), RETURN, LONGEST_US)
        if self.uc.query(self._timed_out):
            raise FrictionloopError(f"the image does not come to rest within {LONGEST_US / 1e6:g} s after reset")

    def rest(self) -> None:
        """Go on in the background until it rests."""
        self._run(self.uc.reg_read(self._arm.UC_ARM_REG_PC) | 1, RETURN)

    def interrupt(self, number: int) -> None:
        """Run an exception from entry to return; 16 and up are interrupts."""
        uc, arm = self.uc, self._arm
        before = uc.reg_read_batch(self._frame)
        old = uc.reg_read(arm.UC_ARM_REG_SP)
        stack = (old - 32) & ~7
        uc.mem_write(stack, struct.pack("<8I", *before[:7], before[7] | THUMB))
        uc.reg_write(arm.UC_ARM_REG_SP, stack)
        uc.reg_write(arm.UC_ARM_REG_LR, RETURN | 1)
        self._run(self.vector(number), RETURN)
        if self.failure is None and uc.reg_read(arm.UC_ARM_REG_SP) != stack:
            raise FrictionloopError("the image returns from an interrupt with another stack pointer")
        after = struct.unpack("<8I", uc.mem_read(stack, 32))
        for register, value in zip(self._frame[:6], after, strict=False):
            uc.reg_write(register, value)
        uc.reg_write(arm.UC_ARM_REG_XPSR, after[7])
        uc.reg_write(arm.UC_ARM_REG_PC, after[6] | 1)
        uc.reg_write(arm.UC_ARM_REG_SP, old)

    def stop(self, why: Exception) -> None:
        """End the run from within a callback; `failure` says why."""
        self.failure = self.failure or why
        self.uc.emu_stop()

    def _run(self, begin: int, until: int, limit_us: int = 0) -> None:
        try:
            self.uc.emu_start(begin | 1, until, limit_us)
        except self._error as error:
            self._fault(str(error))
        if self.failure is not None:
            raise self.failure

    def _fault(self, what: str) -> None:
        """Run the handler of the hard fault, whose end is an endless loop that `stop` leaves."""
        place = self.uc.reg_read(self._arm.UC_ARM_REG_PC)
        reason = FrictionloopError(f"the image faults at 0x{place:08x}: {what}")
        with suppress(self._error):
            self.uc.emu_start(self.vector(HARD_FAULT) | 1, RETURN, LONGEST_US)
        self.failure = reason

    def _read(self, uc: Any, offset: int, width: int, page: int) -> int:
        try:
            return self.bank.read(page + offset, width)
        except FrictionloopError as error:
            self.stop(error)
            return 0

    def _write(self, uc: Any, offset: int, width: int, value: int, page: int) -> None:
        try:
            self.bank.write(page + offset, width, value)
        except FrictionloopError as error:
            self.stop(error)
