"""A bank of registers: their values, and what reading and writing some of them does."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from frictionloop.device.emulator.memory_map import GATES, REGISTERS, Register
from frictionloop.quantities import FrictionloopError


class Bank:
    """Values of all registers by name, with the effects of the peripherals.

    A peripheral puts a function into `on_read[name]`, which gives the value, or `on_write[name]`, which is called after
    the value was stored; `connect` comes after all of them. An access to anything but a whole register of `REGISTERS`
    is an error of the firmware, and so is one to a block whose clock is off: there the processor faults.
    """

    def __init__(self) -> None:
        self.values: dict[str, int] = {register.name: register.reset for register in REGISTERS}
        self.on_read: dict[str, Callable[[], int]] = {}
        self.on_write: dict[str, Callable[[int], None]] = {}
        self._readers: dict[tuple[int, int], Callable[[], int]] = {}
        self._writers: dict[tuple[int, int], Callable[[int], None]] = {}

    def connect(self) -> None:
        """Make the accesses as quick as they can be: a tick has some fifty."""
        for gate in {gate for gate, _ in GATES.values()}:
            self.on_write[gate] = partial(self._open, gate)
        for register in REGISTERS:
            if register.block not in GATES:
                self._connect(register)

    def read(self, address: int, width: int) -> int:
        """Return what the processor reads."""
        try:
            reader = self._readers[address, width]
        except KeyError:
            raise _unreachable("reads", address, width) from None
        return reader()

    def write(self, address: int, width: int, value: int) -> None:
        """Take what the processor writes."""
        try:
            writer = self._writers[address, width]
        except KeyError:
            raise _unreachable("writes", address, width) from None
        writer(value)

    def untouched(self, but: str) -> bool:
        """Return whether all registers are as after reset, except for one."""
        return all(self.values[register.name] == register.reset for register in REGISTERS if register.name != but)

    def _connect(self, register: Register) -> None:
        name, place = register.name, (register.address, register.width)
        self._readers[place] = self.on_read.get(name, partial(self.values.__getitem__, name))
        effect, plain = self.on_write.get(name), partial(self.values.__setitem__, name)
        self._writers[place] = partial(self._store, name, effect) if effect else plain

    def _open(self, gate: str, value: int) -> None:
        """Connect the blocks that have a clock now, and cut off the others."""
        for register in REGISTERS:
            name, bit = GATES.get(register.block, ("", 0))
            if name == gate and value >> bit & 1:
                self._connect(register)
            elif name == gate:
                self._readers.pop((register.address, register.width), None)
                self._writers.pop((register.address, register.width), None)

    def _store(self, name: str, effect: Callable[[int], None], value: int) -> None:
        self.values[name] = value
        effect(value)


def _unreachable(does: str, address: int, width: int) -> FrictionloopError:
    for register in REGISTERS:
        if (register.address, register.width) == (address, width):
            gate, bit = GATES[register.block]
            return FrictionloopError(f"the image {does} {register.name}, whose clock is off ({gate}, bit {bit})")
    return FrictionloopError(
        f"the image {does} {width} bytes at 0x{address:08x}: the model has no such register (emulator/memory_map.py)"
    )
