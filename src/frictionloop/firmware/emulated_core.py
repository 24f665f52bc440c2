"""An image's core on an emulated Cortex-M7, called function by function without a board: instructions of a tick counted.

Unicorn with ``UC_MODE_THUMB`` alone: its ``UC_MODE_MCLASS`` is a Cortex-M33, whatever model is set.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from frictionloop.firmware.image_files import elf_file
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.extra import needed
from frictionloop.quantities.schema import schema

RETURN, SCRATCH, SCRATCH_BYTES = 0x30000000, 0x38000000, 1 << 20
"""Where calls return to, and memory that no image has."""
PAGE = 0x10000
LAW = ("fl_own_step", "fl_look_up", "fl_overdrive")
"""Functions that a law is made of; the rest of a tick is the same for all."""
STROKE, TICKS, MOST = 1000, 2000, 10**7
"""Ticks of a way and of all that are counted (assumed: landing, turns, a reading out of range); instructions of a call."""
FRAMES = 1 << 12
"""Where frames are put together in the scratch."""


class Counted(NamedTuple):
    """The most instructions that any tick took, and that law, inverse and overdrive took in any."""

    tick: int
    law: int


class EmulatedCore:
    """The core of an image in its state after ``fl_app_start`` with the image's own table."""

    def __init__(self, elf: Path) -> None:
        unicorn = needed("unicorn", "unicorn", "emulator")
        self._arm = arm = needed("unicorn.arm_const", "unicorn", "emulator")
        self._cpu = cpu = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
        cpu.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M7)
        with elf.open("rb") as file:
            content = elf_file(file)
            table = content.get_section_by_name(".symtab")
            self.symbols = {each.name: each["st_value"] & ~1 for each in table.iter_symbols() if each.name}
            parts = [(each["p_vaddr"], each["p_memsz"], each.data()) for each in content.iter_segments("PT_LOAD")]
        pages = {page for at, size, _ in parts for page in range(at // PAGE, (at + max(size, 1) - 1) // PAGE + 1)}
        for page in sorted(pages):
            cpu.mem_map(page * PAGE, PAGE)
        for at, size in (RETURN, PAGE), (SCRATCH, SCRATCH_BYTES):
            cpu.mem_map(at, size)
        for at, _, data in parts:
            cpu.mem_write(at, data)
        cpu.reg_write(arm.UC_ARM_REG_FPEXC, 1 << 30)
        self._app, self._top = SCRATCH + 2 * PAGE, SCRATCH + SCRATCH_BYTES - 64
        cpu.mem_write(SCRATCH, bytes(64))  # an identity without a name
        self.call("fl_app_start", self._app, SCRATCH, self.symbols["fl_built_parameters"])
        self._sent = self._session = 0

    def call(self, name: str, *given: int, doubles: Sequence[float] = ()) -> int:
        """Call a function of the image with whole numbers and doubles, and return what is in r0 then."""
        cpu, arm = self._cpu, self._arm
        for k, (bits,) in enumerate(struct.iter_unpack("<Q", struct.pack(f"<{len(doubles)}d", *doubles))):
            cpu.reg_write(arm.UC_ARM_REG_D0 + k, bits)
        cpu.mem_write(self._top, struct.pack(f"<{max(len(given) - 4, 0)}I", *given[4:]))
        cpu.reg_write(arm.UC_ARM_REG_SP, self._top)
        cpu.reg_write(arm.UC_ARM_REG_LR, RETURN | 1)
        for k, number in enumerate(given[:4]):
            cpu.reg_write(arm.UC_ARM_REG_R0 + k, number)
        try:
            cpu.emu_start(self.symbols[name] | 1, RETURN, count=MOST)
        except (KeyError, needed("unicorn", "unicorn", "emulator").UcError) as error:
            raise FrictionloopError(f"{name}: {error}", "BAD-IMAGE") from None
        return int(cpu.reg_read(arm.UC_ARM_REG_R0))

    def tick(self, sample: Sequence[int], now_us: int) -> tuple[int, float]:
        """Run a tick with counts of force, across, position and load; return duty (2^-17) and amplitude in um."""
        at, to = SCRATCH + 64, SCRATCH + 128
        self._cpu.mem_write(at, struct.pack("<4i", *sample))
        self.call("fl_app_tick", to, self._app, at, now_us % 2**32, 0)
        duty, amplitude_um = struct.unpack("<i4xd", self._cpu.mem_read(to, 16))
        return duty, amplitude_um

    def law(
        self, state: Sequence[float], measured: Sequence[float], setpoint_n: float, low: float, high: float
    ) -> bytes:
        """Run a tick of the law alone; return the bytes of its state, of u and of saturated."""
        at, seen = SCRATCH + FRAMES, SCRATCH + 2 * FRAMES
        self._cpu.mem_write(at, struct.pack(f"<{len(state)}d", *state))
        self._cpu.mem_write(seen, struct.pack("<5d", *measured))
        self.call("fl_own_step", at, seen, self.symbols["fl_built_parameters"], doubles=(setpoint_n, low, high))
        out = (self._cpu.reg_read(self._arm.UC_ARM_REG_D0 + k) for k in range(2))
        return bytes(self._cpu.mem_read(at, 8 * len(state))) + struct.pack("<2Q", *out)

    def ask(self, name: str, body: bytes, now_us: int) -> None:
        """Give it the frame of a message; ``hello`` begins the session of those that follow."""
        kind = next(each["type"] for each in schema()["message"] if each["name"] == name)
        self._sent += 1
        frame = struct.pack("<BHI", kind, self._sent, 0 if name == "hello" else self._session) + body
        self._cpu.mem_write(SCRATCH + FRAMES, frame)
        coded = self.call("fl_frame_encode", SCRATCH + 2 * FRAMES, FRAMES, SCRATCH + FRAMES, len(frame))
        self.call("fl_app_receive", self._app, SCRATCH + 2 * FRAMES, coded, now_us)
        if name == "hello":
            self._session = int.from_bytes(body[1:5], "little") + 1

    def watch(self, entered: Any) -> None:
        """Let a function of the address be called at every instruction."""
        hook = needed("unicorn", "unicorn", "emulator").UC_HOOK_CODE
        self._cpu.hook_add(hook, lambda _cpu, at, _size, _user: entered(at))

    @property
    def returns_to(self) -> int:
        """Where the function that was just entered returns to."""
        return int(self._cpu.reg_read(self._arm.UC_ARM_REG_LR)) & ~1


def counted(elf: Path, tick_hz: int) -> Counted:
    """Return the instructions of the worst tick of an image, its loop closed, telemetry of every tick kept."""
    core, names = EmulatedCore(elf), schema()
    tick_us = 1_000_000 // tick_hz
    now_us, most, law = 0, 0, 0
    spent = {"tick": 0, "law": 0}
    law_at = {core.symbols[name] for name in LAW if name in core.symbols}
    back: list[int] = []

    def entered(at: int) -> None:
        spent["tick"] += 1
        if at in law_at and not back:
            back.append(core.returns_to)
        if back:
            if at == back[0]:
                back.clear()
            else:
                spent["law"] += 1

    core.ask("hello", bytes([names["protocol"]["major"]]) + (1).to_bytes(4, "little"), 0)
    core.ask("stream", struct.pack("<HH", 1, 255), 0)
    core.ask("mode", bytes([names["states"]["closed"]]), 0)
    core.watch(entered)
    for k in range(TICKS):
        now_us += tick_us
        if k % 100 == 99:
            core.ask("heartbeat", b"", now_us)
        phase = k % (2 * STROKE)
        way = phase if phase < STROKE else 2 * STROKE - phase
        sample = (8000 + 37 * (k % 23) - (40000 if k == TICKS - 100 else 0), 300, 16 * way - 8000, 3277)
        spent.update(tick=0, law=0)
        core.tick(sample, now_us)
        most, law = max(most, spent["tick"]), max(law, spent["law"])
    return Counted(most, law)
