"""A line that went away, tried again beside what goes on: a device that answers nothing holds nobody up."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from frictionloop.device.errors import DeviceError

RETRY_S = 1.0
"""How often a line that went away is tried again (assumed)."""
LONGEST_TRY_S = 5.0
"""How long the end waits for a try that is under way: longer than a device may take to answer."""


class LineAgain:
    """Tries to open a line again, on a thread of its own, until it is there; while it is `away` nobody else uses it."""

    def __init__(self, reconnect: Callable[[], None]) -> None:
        self._reconnect, self._thread = reconnect, threading.Thread()
        self._began_s, self._opened = -RETRY_S, False
        self.away = False
        """Whether the line is not there."""

    def lost(self) -> None:
        """Take the line for away until a try succeeds."""
        self.away = True

    def try_on(self) -> None:
        """Begin a try where the line is away, unless one is under way or began less than `RETRY_S` ago."""
        if not self.away or self._thread.is_alive() or time.monotonic() - self._began_s < RETRY_S:
            return
        self._began_s = time.monotonic()
        self._thread = threading.Thread(target=self._try, daemon=True)
        self._thread.start()

    def opened(self) -> bool:
        """Return, once, that a try has succeeded."""
        was, self._opened = self._opened, False
        return was

    def end(self) -> None:
        """Wait for a try that is under way."""
        if self._thread.is_alive():
            self._thread.join(LONGEST_TRY_S)

    def _try(self) -> None:
        try:
            self._reconnect()
        except DeviceError:  # silent still, or gone again: the next try is due in a second
            return
        self._opened, self.away = True, False
