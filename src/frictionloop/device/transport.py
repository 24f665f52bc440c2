"""What a device hangs on, by its address: a serial port, a TCP connection, or a simulated bench."""

from __future__ import annotations

import errno
import re
import select
import socket
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np

from frictionloop.device.errors import DeviceError, Unplugged
from frictionloop.parameters import System, bench
from frictionloop.quantities import must_be
from frictionloop.quantities.optional_libraries import needed


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


BAUD = 2_000_000
"""Of the board: 24 MHz / 12, exactly."""
_BULK = 65536
_GONE_AFTER_S = 1.0  # a write that does not get through for so long has no one at the other end (assumed)


class SerialPipe(Pipe):
    """A serial port that no other program may have at the same time (Linux and macOS; on Windows it is not tried).

    Raises
    ------
    DeviceError
        For a port that does not exist, is not ours to open, or is in use.
    """

    def __init__(self, port: str) -> None:
        serial = needed("serial", "pyserial")
        self._name, self._gone = port, (serial.SerialException, OSError)
        try:
            self._port = serial.Serial(port, BAUD, timeout=0, write_timeout=_GONE_AFTER_S, exclusive=True)
        except (serial.SerialException, OSError, ValueError) as error:
            raise DeviceError(f"{port}: {_why(port, getattr(error, 'errno', None), error)}", "NO-DEVICE") from None

    def read(self, timeout_s: float) -> bytes:
        """Return what has come in, waiting up to so long for the first byte."""
        try:
            if sys.platform == "win32":  # no ports in select there
                self._port.timeout = max(timeout_s, 0.0)
                return bytes(self._port.read(1) + self._port.read(self._port.in_waiting))
            # in_waiting and single bytes starve at 83 kB/s: wait for any, then take all there is.
            select.select([self._port.fileno()], [], [], max(timeout_s, 0.0))
            return bytes(self._port.read(_BULK))
        except self._gone as error:
            raise Unplugged(f"{self._name}: unplugged ({error})") from None

    def write(self, data: bytes) -> None:
        """Send bytes."""
        try:
            self._port.write(data)
        except self._gone as error:
            raise Unplugged(f"{self._name}: unplugged ({error})") from None

    def close(self) -> None:
        """Let go of the port."""
        self._port.close()

    def clock(self) -> float:
        """Return the time in s."""
        return time.monotonic()


def described_ports() -> list[tuple[str, str]]:
    """Return the address of each serial port of this machine, and what it says it is."""
    found = needed("serial.tools.list_ports", "pyserial").comports()
    return [(f"serial://{port.device}", port.description) for port in found if port.hwid != "n/a"]


def _why(port: str, code: int | None, error: Exception) -> str:
    if code == errno.ENOENT:
        return f"no such port; there is {', '.join(address for address, _ in described_ports()) or 'none'}"
    if code == errno.EACCES and sys.platform != "win32":
        group = Path(port).group()
        return f"permission denied; sudo usermod -aG {group} $USER"
    if code in (errno.EBUSY, errno.EAGAIN, errno.EACCES):
        return "in use by another program"
    return f"cannot be opened ({str(error).splitlines()[0]})"


_PATIENCE_S = 2.0  # for a connection, and for a write that does not get through (assumed)


class TcpPipe(Pipe):
    """A connection to a board that listens; raises DeviceError where nobody does."""

    def __init__(self, host: str, port: int) -> None:
        self._name = f"tcp://{host}:{port}"
        try:
            self._socket = socket.create_connection((host, port), _PATIENCE_S)
        except OSError as error:
            raise DeviceError(f"{self._name}: cannot be reached ({error.strerror or error})", "NO-DEVICE") from None
        # A request is a frame of some ten bytes that waits for its answer: held back it takes 40 ms.
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def read(self, timeout_s: float) -> bytes:
        """Return what has come in, waiting up to so long for the first byte."""
        try:
            if not select.select([self._socket], [], [], max(timeout_s, 0.0))[0]:
                return b""
            data = self._socket.recv(_BULK)
        except (OSError, ValueError) as error:
            raise Unplugged(f"{self._name}: connection gone ({error})") from None
        if not data:
            raise Unplugged(f"{self._name}: closed by the other side")
        return data

    def write(self, data: bytes) -> None:
        """Send bytes."""
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise Unplugged(f"{self._name}: connection gone ({error})") from None

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def clock(self) -> float:
        """Return the time in s."""
        return time.monotonic()


ADDRESSES = "sim:, emulated:IMAGE, tcp://HOST:PORT, serial:///dev/ttyACM0, serial://COM3"

_PORT = re.compile(r"COM\d+$|/dev/")
"""What a serial port is called by itself."""


def opener(address: str, system: System | None = None, seed: int = 0) -> Callable[[], Pipe]:
    """Return what opens the pipe of an address, as often as it is called; `bench()` is behind a simulated one."""
    scheme, colon, rest = address.partition(":")
    if colon and scheme == "serial" and len(rest) > 2 and rest.startswith("//"):
        return lambda: SerialPipe(rest[2:])
    if colon and scheme == "tcp" and rest.startswith("//"):
        host, _, port = rest[2:].rpartition(":")
        if host and port.isdecimal() and 0 < int(port) < 2**16:
            return lambda: TcpPipe(host.strip("[]"), int(port))
    if address == "sim:" or (scheme == "emulated" and rest):
        from frictionloop.device.simulated_boards import BenchPipe, Board, Emulated, Simulated

        given = system or bench()
        board: Board = Emulated(rest, given.plate.max_amplitude_um) if rest else Simulated(given)
        return BenchPipe(board, given, seed).opened
    raise must_be("address", address, f"serial://{address}" if _PORT.match(address) else ADDRESSES)
