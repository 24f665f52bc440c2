"""Ends a stretch of an image that never does: an endless loop, which on the board the watchdog ends."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LONGEST_S = 5.0
"""Of the host's time, at least; at most twice that (assumed: a tick takes a millisecond)."""


class Patience:
    """One thread looks at whether a stretch still is the one it saw last.

    Unicorn's own limit of time starts a thread for each stretch, with which a tick takes three times as long.
    """

    def __init__(self, stop: Callable[[], None], longest_s: float = LONGEST_S) -> None:
        self._stop = stop
        self._stretch, self._runs = 0, False
        self.lost = False
        """Whether the last stretch was ended by the clock."""
        closed = threading.Event()
        weakref.finalize(self, closed.set)
        threading.Thread(target=_watch, args=(weakref.ref(self), closed, longest_s), daemon=True).start()

    @contextmanager
    def stretch(self) -> Iterator[None]:
        """Look at what happens within."""
        self.lost = False
        self._stretch += 1
        self._runs = True
        try:
            yield
        finally:
            self._runs = False

    def look(self, seen: int) -> int:
        """End the stretch if it is the one that was seen; return its number, 0 while none runs."""
        now = self._stretch if self._runs else 0
        if now and now == seen:
            self.lost = True
            self._stop()
        return now


def _watch(patience: weakref.ref[Patience], closed: threading.Event, longest_s: float) -> None:
    seen = 0
    while not closed.wait(longest_s):
        held = patience()
        if held is None:
            return
        seen = held.look(seen)
        del held
