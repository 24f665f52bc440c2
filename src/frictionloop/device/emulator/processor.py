"""A Cortex-M4 in unicorn: memory, registers behind callbacks, reset, interrupts, rest, and an end to what has none."""

from __future__ import annotations

import signal
import struct
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from frictionloop.device.emulator.registers import FLASH, PAGE, PAGES, RAM, Bank
from frictionloop.firmware.image_files import FLASH_BYTES, RAM_BYTES, check_teensy, loaded
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.extra import needed

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
HARD_FAULT, VECTORS = 3, 16 + 95
FRAME_BYTES = 32
"""Eight registers on the stack (ARMv7-M B1.5.6)."""
FRAME = bytes(range(1, FRAME_BYTES + 1))
"""Put there in their place, to be found again: unicorn keeps the registers themselves."""


class Processor:
    """Runs an image from its reset vector; interrupts come when they are asked for, and run to their end.

    Unicorn has no interrupt controller, so `interrupt` does what the hardware does: registers kept, room for them on
    the stack, the vector, and back. The background runs until it waits for an interrupt (WFI).
    """

    def __init__(self, image_path: Path, bank: Bank) -> None:
        unicorn = needed("unicorn", "unicorn", "emulator")
        arm = self._arm = needed("unicorn.arm_const", "unicorn", "emulator")
        self._error = unicorn.UcError
        self._read_register, self._write_register = bank.read, bank.write
        self.failure: Exception | None = None
        self.on_access: Callable[[], None] | None = None
        uc = self.uc = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        self._patience = Patience(uc.emu_stop)
        uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        uc.mem_map(FLASH, FLASH_BYTES, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        uc.mem_map(RAM, RAM_BYTES, unicorn.UC_PROT_ALL)
        for page in PAGES:
            uc.mmio_map(page, PAGE, self._read, page, self._write, page)
        uc.mem_write(FLASH, b"\xff" * FLASH_BYTES)  # erased
        segments = loaded(image_path)
        check_teensy(str(image_path), segments)
        for address, content in segments:
            if address + len(content) > FLASH_BYTES:
                raise FrictionloopError(f"{image_path}: 0x{address:08x} outside the flash", "BAD-IMAGE")
            uc.mem_write(address, content)
        self._background = uc.context_save()
        self._vectors = struct.unpack(f"<{VECTORS}I", uc.mem_read(FLASH, 4 * VECTORS))

    def vector(self, number: int) -> int:
        """Return an entry of the vector table."""
        return self._vectors[number]

    def reset(self) -> None:
        """Begin as after power comes, and go on until the background first rests."""
        self.uc.reg_write(self._arm.UC_ARM_REG_SP, self.vector(0))
        self._run(self.vector(1))

    def rest(self) -> None:
        """Go on in the background until it rests."""
        self._run(self.uc.reg_read(self._arm.UC_ARM_REG_PC))

    def interrupt(self, number: int) -> None:
        """Run an exception from entry to return; 16 and up are interrupts."""
        uc, arm = self.uc, self._arm
        uc.context_update(self._background)
        stack = (uc.reg_read(arm.UC_ARM_REG_SP) - FRAME_BYTES) & ~7
        uc.mem_write(stack, FRAME)
        uc.reg_write(arm.UC_ARM_REG_SP, stack)
        uc.reg_write(arm.UC_ARM_REG_LR, RETURN | 1)
        self._run(self.vector(number))
        if uc.reg_read(arm.UC_ARM_REG_SP) != stack or uc.mem_read(stack, FRAME_BYTES) != FRAME:
            raise FrictionloopError("image: another stack after an interrupt", "BAD-IMAGE")
        uc.context_restore(self._background)

    def stop(self, why: Exception) -> None:
        """End the run from within a callback; `failure` says why."""
        self.failure = self.failure or why
        self.uc.emu_stop()

    def _run(self, begin: int) -> None:
        with _whole(), self._patience.stretch():
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
        place = self.uc.reg_read(self._arm.UC_ARM_REG_PC)
        reason = FrictionloopError(f"the image faults at 0x{place:08x}: {what}")
        with suppress(self._error):
            self.uc.emu_start(self.vector(HARD_FAULT) | 1, RETURN)
        self.failure = reason

    def _read(self, uc: Any, offset: int, width: int, page: int) -> int:
        if self.on_access:
            self.on_access()
        try:
            return self._read_register(page + offset, width)
        except FrictionloopError as error:
            self.stop(error)
            return 0

    def _write(self, uc: Any, offset: int, width: int, value: int, page: int) -> None:
        if self.on_access:
            self.on_access()
        try:
            self._write_register(page + offset, width, value)
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
