"""Which pipe an address means."""

from __future__ import annotations

import re
from collections.abc import Callable

from frictionloop.device.pipe import Pipe
from frictionloop.parameters import System, bench
from frictionloop.quantities import must_be

ADDRESSES = "sim:, emulated:IMAGE, tcp://HOST:PORT, serial:///dev/ttyACM0, serial://COM3"

_PORT = re.compile(r"COM\d+$|/dev/")
"""What a serial port is called by itself."""


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
        from frictionloop.device.boards import Board, Emulated, Simulated
        from frictionloop.device.simulated_pipe import BenchPipe

        given = system or bench()
        board: Board = Emulated(rest, given.plate.max_amplitude_um) if rest else Simulated(given)
        return BenchPipe(board, given, seed).opened
    raise must_be("address", address, f"serial://{address}" if _PORT.match(address) else ADDRESSES)
