"""A bank of registers: their values, and what reading and writing some of them does."""

from __future__ import annotations

from collections.abc import Callable

from frictionloop.device.emulator.memory_map import REGISTERS, Register
from frictionloop.quantities import FrictionloopError


class Bank:
    """Values of all registers by name, with the effects of the peripherals.

    A peripheral puts a function into `on_read[name]`, which gives the value, or `on_write[name]`, which is called after the
    value was stored. An access to anything but a whole register of `REGISTERS` is an error of the firmware.
    """

    def __init__(self) -> None:
        self.values: dict[str, int] = {register.name: register.reset for register in REGISTERS}
        self.on_read: dict[str, Callable[[], int]] = {}
        self.on_write: dict[str, Callable[[int], None]] = {}
        self.first: list[tuple[str, int]] = []
        self._at: dict[int, Register] = {register.address: register for register in REGISTERS}

    def read(self, address: int, width: int) -> int:
        """Return what the processor reads."""
        name = self._register(address, width, "reads").name
        effect = self.on_read.get(name)
        return effect() if effect else self.values[name]

    def write(self, address: int, width: int, value: int) -> None:
        """Take what the processor writes."""
        name = self._register(address, width, "writes").name
        self.values[name] = value
        if len(self.first) < 2:
            self.first.append((name, value))
        effect = self.on_write.get(name)
        if effect:
            effect(value)

    def _register(self, address: int, width: int, does: str) -> Register:
        register = self._at.get(address)
        if register is None or register.width != width:
            raise FrictionloopError(
                f"the image {does} {width} bytes at 0x{address:08x}: the model has no such register (emulator/memory_map.py)"
            )
        return register
