"""A serial port: the board's UART behind an adapter, or USB."""

from __future__ import annotations

import errno
import os
import select
import time
from pathlib import Path

from frictionloop.device.errors import DeviceError, Unplugged
from frictionloop.device.pipe import Pipe
from frictionloop.quantities.extra import needed

BAUD = 2_000_000
"""Of the Teensy's UART0: 72 MHz / 16 / 2.25, exactly."""
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
            if os.name == "nt":  # no ports in select there
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
    if code == errno.EACCES and os.name != "nt":
        group = Path(port).group()
        return f"permission denied; sudo usermod -aG {group} $USER"
    if code in (errno.EBUSY, errno.EAGAIN, errno.EACCES):
        return "in use by another program"
    return f"cannot be opened ({str(error).splitlines()[0]})"
