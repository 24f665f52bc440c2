"""A bank of registers: their values, and what reading and writing some of them does."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from frictionloop.device.emulator.memory_map import REGISTERS
from frictionloop.quantities import FrictionloopError


class Bank:
    """Values of all registers by name, with the effects of the peripherals.

    A peripheral puts a function into `on_read[name]`, which gives the value, or `on_write[name]`, which is called after
    the value was stored; `connect` comes after all of them. An access to anything but a whole register of `REGISTERS`
    is an error of the firmware.
    """

    def __init__(self) -> None:
        self.values: dict[str, int] = {register.name: register.reset for register in REGISTERS}
        self.on_read: dict[str, Callable[[], int]] = {}
        self.on_write: dict[str, Callable[[int], None]] = {}
        self._readers: dict[tuple[int, int], Callable[[], int]] = {}
        self._writers: dict[tuple[int, int], Callable[[int], None]] = {}

    def connect(self) -> None:
        """Make the accesses as quick as they can be: a tick has some fifty."""
        for name, address, width, _ in REGISTERS:
            plain = partial(self.values.__getitem__, name), partial(self.values.__setitem__, name)
            self._readers[address, width] = self.on_read.get(name, plain[0])
            effect = self.on_write.get(name)
            self._writers[address, width] = partial(self._store, name, effect) if effect else plain[1]

    def read(self, address: int, width: int) -> int:
        """Return what the processor reads."""
        try:
            reader = self._readers[address, width]
        except KeyError:
            raise _unknown("reads", address, width) from None
        return reader()

    def write(self, address: int, width: int, value: int) -> None:
        """Take what the processor writes."""
        try:
            writer = self._writers[address, width]
        except KeyError:
            raise _unknown("writes", address, width) from None
        writer(value)

    def untouched(self, but: str) -> bool:
        """Return whether all registers are as after reset, except for one."""
        return all(self.values[register.name] == register.reset for register in REGISTERS if register.name != but)

    def _store(self, name: str, effect: Callable[[int], None], value: int) -> None:
        self.values[name] = value
        effect(value)


def _unknown(does: str, address: int, width: int) -> FrictionloopError:
    return FrictionloopError(
        f"the image {does} {width} bytes at 0x{address:08x}: the model has no such register (emulator/memory_map.py)"
    )
