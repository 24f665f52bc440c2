"""A Cortex-M7 in unicorn: memory, registers behind callbacks, reset, interrupts, rest, and an end to what has none."""

from __future__ import annotations

import signal
import struct
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from frictionloop.device.emulator.registers import PAGE, PAGES, Bank
from frictionloop.firmware.image_files import FLASH, FLASH_BYTES, RAM_BYTES, check_teensy, entry_of, loaded
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.optional_libraries import needed

LONGEST_S = 5.0
"""Of the host's time, at least; at most twice that (assumed: a tick takes a millisecond)."""


class Patience:
    """One thread looks at whether a stretch still is the one it saw last.

    Unicorn's own limit of time starts a thread for each stretch, with which a tick takes three times as long.
    """

    def __init__(self, stop: Callable[[], None], longest_s: float = LONGEST_S) -> None:
        self._stop = stop
        self._stretch, self._runs = 0, False
        self.lost = False
        """Whether the last stretch was ended by the clock."""
        closed = threading.Event()
        weakref.finalize(self, closed.set)
        threading.Thread(target=_watch, args=(weakref.ref(self), closed, longest_s), daemon=True).start()

    @contextmanager
    def stretch(self) -> Iterator[None]:
        """Look at what happens within."""
        self.lost = False
        self._stretch += 1
        self._runs = True
        try:
            yield
        finally:
            self._runs = False

    def look(self, seen: int) -> int:
        """End the stretch if it is the one that was seen; return its number, 0 while none runs."""
        now = self._stretch if self._runs else 0
        if now and now == seen:
            self.lost = True
            self._stop()
        return now


def _watch(patience: weakref.ref[Patience], closed: threading.Event, longest_s: float) -> None:
    seen = 0
    while not closed.wait(longest_s):
        held = patience()
        if held is None:
            return
        seen = held.look(seen)
        del held


RETURN = 0x10000000
"""Where an interrupt returns to, an address without memory: unicorn does not know the hardware's 0xFFFFFFF9."""
HARD_FAULT = 3
FRAME_BYTES = 104
"""Eight registers and eighteen of floating point on the stack (ARMv7-M B1.5.7)."""
INSTRUCTIONS, DATA = 0, 0x20000000
"""Tightly coupled memories."""
BY_REGISTER = 1 << 2
"""Of GPR16: FlexRAM is shared out by GPR17, not by fuses."""
FLOATING_POINT = 0xF << 20
"""Of CPACR: coprocessors 10 and 11."""


def is_floating_point(code: bytes) -> bool:
    """Return whether an instruction is one of coprocessor 10 or 11 (ARMv7-M A5.3.18)."""
    first, second = struct.unpack("<2H", code.ljust(4, b"\0")[:4])
    return len(code) == 4 and first & 0xEC00 == 0xEC00 and second >> 9 & 7 == 5


class Processor:
    """Runs an image from where the ROM enters it; interrupts come when they are asked for, and run to their end.

    Unicorn has no interrupt controller, so `interrupt` does what the hardware does: registers kept, room for them on
    the stack, the vector, and back. The background runs until it waits for an interrupt (WFI). Unicorn's floating-point
    unit is on from the first instruction, the hardware's is not: an image that does not switch it on is refused.

    In unicorn's mode MCLASS any processor is a Cortex-M33; without it a Cortex-M7 is one (2.1.4).
    """

    def __init__(self, image_path: Path, bank: Bank) -> None:
        unicorn = needed("unicorn", "unicorn", "emulator")
        arm = self.arm = needed("unicorn.arm_const", "unicorn", "emulator")
        self._error, self.image = unicorn.UcError, image_path
        self._bank = bank
        self.failure: Exception | None = None
        uc = self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
        self._patience = Patience(uc.emu_stop)
        uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M7)
        self._shares = ((INSTRUCTIONS, 0b11, unicorn.UC_PROT_ALL), (DATA, 0b10, 3))
        uc.mem_map(FLASH, 2**23, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        for page in PAGES:
            uc.mmio_map(page, PAGE, self._read, page, self._write, page)
        uc.mem_write(FLASH, b"\xff" * FLASH_BYTES)  # erased
        self._load(loaded(image_path))
        self._background = uc.context_save()
        self._without = uc.hook_add(unicorn.UC_HOOK_CODE, self._step)
        bank.on_write["SCB_CPACR"] = self._switched
        bank.on_write["IOMUXC_GPR_GPR16"] = self._share

    def _load(self, segments: list[tuple[int, bytes]]) -> None:
        check_teensy(str(self.image), segments)
        for address, content in segments:
            if not FLASH <= address <= FLASH + FLASH_BYTES - len(content):
                raise FrictionloopError(f"{self.image}: 0x{address:08x} outside the flash", "BAD-IMAGE")
            self.uc.mem_write(address, content)
        self._entry = entry_of(segments) or 0

    def vector(self, number: int) -> int:
        """Return an entry of the vector table."""
        (place,) = struct.unpack("<I", self.uc.mem_read(self._bank.values["SCB_VTOR"] + 4 * number, 4))
        return int(place)

    def reset(self) -> None:
        """Begin as after power comes, and go on until the background first rests."""
        with self.stretch():
            self._run(self._entry)
        if self._bank.values["SCB_CPACR"] & FLOATING_POINT != FLOATING_POINT:
            raise FrictionloopError(f"{self.image}: floating point not switched on, CPACR", "BAD-IMAGE")

    def rest(self) -> None:
        """Go on in the background until it rests."""
        self._run(self.uc.reg_read(self.arm.UC_ARM_REG_PC))

    def interrupt(self, number: int, pending: Callable[[], bool] = lambda: False) -> None:
        """Run an exception from entry to return, again while it is pending; 16 and up are interrupts."""
        uc, arm = self.uc, self.arm
        uc.context_update(self._background)
        stack = (uc.reg_read(arm.UC_ARM_REG_SP) - FRAME_BYTES) & ~7
        uc.reg_write(arm.UC_ARM_REG_SP, stack)
        begin, again = self.vector(number), True
        while again:
            uc.reg_write(arm.UC_ARM_REG_LR, RETURN | 1)
            self._run(begin)
            again = pending()
        if uc.reg_read(arm.UC_ARM_REG_SP) != stack:
            raise FrictionloopError("image: another stack after an interrupt", "BAD-IMAGE")
        uc.context_restore(self._background)

    def stop(self, why: Exception) -> None:
        """End the run from within a callback; `failure` says why."""
        self.failure = self.failure or why
        self.uc.emu_stop()

    @contextmanager
    def stretch(self) -> Iterator[None]:
        """Let what runs within be whole, and end it where it does not come to an end."""
        with _whole(), self._patience.stretch():
            yield

    def _run(self, begin: int) -> None:
        try:
            self.uc.emu_start(begin | 1, RETURN)
        except self._error as error:
            self._fault(str(error))
        if self._patience.lost:
            self.failure = self.failure or FrictionloopError(f"image: does not come to rest within {LONGEST_S:g} s")
        if self.failure is not None:
            raise self.failure

    def _fault(self, what: str) -> None:
        """Run the handler of the hard fault, whose end is an endless loop that `stop` leaves."""
        place = self.uc.reg_read(self.arm.UC_ARM_REG_PC)
        reason = FrictionloopError(f"the image faults at 0x{place:08x}: {what}")
        with suppress(self._error):
            self.uc.emu_start(self.vector(HARD_FAULT) | 1, RETURN)
        self.failure = reason

    def _step(self, uc: Any, address: int, size: int, _: Any) -> None:
        """Look at an instruction before floating point is on."""
        if is_floating_point(bytes(uc.mem_read(address, size))):
            self.stop(FrictionloopError(f"{self.image}: 0x{address:08x} before CPACR is written", "BAD-IMAGE"))

    def _share(self, value: int) -> None:
        """Put the banks of memory where GPR17 says, two bits each; before, there are none."""
        banks = [self._bank.values["IOMUXC_GPR_GPR17"] >> 2 * k & 3 for k in range(16)]
        for place, kind, rights in self._shares:
            if value & BY_REGISTER and kind in banks:
                self.uc.mem_map(place, banks.count(kind) * RAM_BYTES // 16, rights)

    def _switched(self, value: int) -> None:
        if self._without is not None and value & FLOATING_POINT == FLOATING_POINT:
            self.uc.hook_del(self._without)
            self._without = None

    def _read(self, uc: Any, offset: int, width: int, page: int) -> int:
        try:
            return self._bank.read(page + offset, width)
        except FrictionloopError as error:
            self.stop(error)
            return 0

    def _write(self, uc: Any, offset: int, width: int, value: int, page: int) -> None:
        try:
            self._bank.write(page + offset, width, value)
        except FrictionloopError as error:
            self.stop(error)


@contextmanager
def _whole() -> Iterator[None]:
    """Let Ctrl-C wait until unicorn has returned: raised inside one of its callbacks it would be lost."""
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield
        return
    pressed: list[bool] = []
    signal.signal(signal.SIGINT, lambda *_: pressed.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        before(signal.SIGINT, None)
