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
    """Tries to open a line again, on a thread of its own; while `trying`, nobody else may use the line."""

    def __init__(self, reconnect: Callable[[], None]) -> None:
        self._reconnect, self._thread = reconnect, threading.Thread()
        self._began_s, self._is_open = -RETRY_S, False

    @property
    def trying(self) -> bool:
        """Whether a try is under way."""
        return self._thread.is_alive()

    def begin(self) -> None:
        """Begin a try, unless the last one began less than `RETRY_S` ago."""
        if time.monotonic() - self._began_s < RETRY_S:
            return
        self._began_s = time.monotonic()
        self._thread = threading.Thread(target=self._try, daemon=True)
        self._thread.start()

    def opened(self) -> bool:
        """Return, once, that a try has succeeded."""
        was, self._is_open = self._is_open, False
        return was

    def end(self) -> None:
        """Wait for a try that is under way."""
        if self.trying:
            self._thread.join(LONGEST_TRY_S)

    def _try(self) -> None:
        try:
            self._reconnect()
            self._is_open = True
        except DeviceError:
            return
