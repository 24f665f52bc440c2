"""What a device hangs on: a line for bytes, whatever carries them."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from frictionloop.parameters import System


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
