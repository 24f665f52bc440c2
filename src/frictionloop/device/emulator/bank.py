"""A bank of registers: their values, and what reading and writing some of them does."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from frictionloop.device.emulator.memory_map import GATES, REGISTERS
from frictionloop.quantities import FrictionloopError

PLACES = {(each.address, each.width): (each.name, *GATES.get(each.block, ("", 0))) for each in REGISTERS}
"""Name of the register at an address, whole, and register and bit of the clock that it needs."""


class Bank:
    """Values of all registers by name, with the effects of the peripherals.

    A peripheral puts a function into `on_read[name]`, which gives the value, or `on_write[name]`, which is called after
    the value was stored. An access to anything but a whole register of `REGISTERS` is an error of the firmware, and so
    is one to a block whose clock is off: there the processor faults. `begun` are values that differ from those after
    power comes.
    """

    def __init__(self, begun: Mapping[str, int] | None = None) -> None:
        self._begun = {register.name: register.reset for register in REGISTERS} | dict(begun or {})
        self.values: dict[str, int] = dict(self._begun)
        self.on_read: dict[str, Callable[[], int]] = {}
        self.on_write: dict[str, Callable[[int], None]] = {}

    def read(self, address: int, width: int) -> int:
        """Return what the processor reads."""
        name = self._reached("reads", address, width)
        effect = self.on_read.get(name)
        return effect() if effect else self.values[name]

    def write(self, address: int, width: int, value: int) -> None:
        """Take what the processor writes."""
        name = self._reached("writes", address, width)
        self.values[name] = value
        effect = self.on_write.get(name)
        if effect:
            effect(value)

    def untouched(self, but: str) -> bool:
        """Return whether all registers are as after reset, except for one."""
        return all(self.values[name] == value for name, value in self._begun.items() if name != but)

    def _reached(self, does: str, address: int, width: int) -> str:
        name, gate, bit = PLACES.get((address, width), ("", "", 0))
        if not name:
            raise FrictionloopError(f"image {does} 0x{address:08x}, {width} bytes: no register", "BAD-IMAGE")
        if gate and not self.values[gate] >> bit & 1:
            raise FrictionloopError(f"image {does} {name}: clock off, {gate} bit {bit}", "BAD-IMAGE")
        return name
