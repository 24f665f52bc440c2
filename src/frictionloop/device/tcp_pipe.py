"""A TCP connection: an emulator, or an adapter with a network."""

from __future__ import annotations

import select
import socket
import time

from frictionloop.device.errors import DeviceError, Unplugged
from frictionloop.device.pipe import Pipe

_BULK = 65536
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
