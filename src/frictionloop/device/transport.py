"""Byte pipes: what a device hangs on, and the address that says which."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from frictionloop.parameters import System, bench
from frictionloop.quantities import FrictionloopError

ADDRESSES = "sim:, emulated:image.elf, serial:///dev/ttyACM0, tcp://host:port"


class Pipe(Protocol):
    """A line that carries bytes both ways. It has the clock that its host lives by: simulated boards have their own."""

    source: str = "device"
    """What is behind it: simulated, emulated or device."""
    system: System | None = None
    """What the board was set up from, where it is known."""

    def read(self, timeout_s: float) -> bytes:
        """Return what has come in, all of it; wait up to so long for the first byte, b"" when none came.

        Raises
        ------
        Unplugged
            When the line is gone.
        """

    def write(self, data: bytes) -> None:
        """Send bytes, all of them; raises Unplugged as well."""

    def close(self) -> None:
        """Let go of the line; it may be closed already."""

    def clock(self) -> float:
        """Return the time in s, from any start."""

    def felt(self, first_tick: int, count: int, every: int) -> np.ndarray | None:
        """Return the friction force on the finger at ticks of the board; None where nobody knows it."""
        return None


def opener(address: str, system: System | None = None, seed: int = 0) -> Callable[[], Pipe]:
    """Return what opens the pipe of an address, as often as it is called; `bench()` is behind a simulated one.

    Raises
    ------
    FrictionloopError
        For an address of no known form.
    """
    scheme, colon, rest = address.partition(":")
    if colon and scheme == "serial" and len(rest) > 2 and rest.startswith("//"):
        from frictionloop.device.serial_pipe import SerialPipe

        return lambda: SerialPipe(rest[2:])
    if colon and scheme == "tcp" and rest.startswith("//"):
        host, _, port = rest[2:].rpartition(":")
        if host and port.isdecimal() and 0 < int(port) < 2**16:
            from frictionloop.device.tcp_pipe import TcpPipe

            return lambda: TcpPipe(host.strip("[]"), int(port))
    if address == "sim:" or (scheme == "emulated" and rest):
        from frictionloop.device.simulated_pipe import BenchPipe, Simulated

        given = system or bench()
        if address == "sim:":
            return BenchPipe(Simulated(given), given, seed).opened
        from frictionloop.device.emulated_board import Emulated

        return BenchPipe(Emulated(rest, given.plate.max_amplitude_um), given, seed).opened
    raise FrictionloopError(f"address {address!r}: must be one of {ADDRESSES}")
