"""What ends a run from outside: Ctrl-C, a terminal that closes, a service that is stopped."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
"""SIGHUP is not on every system."""


class Ending:
    """Signals while a run is recorded: the first raises KeyboardInterrupt, later ones wait for what is being saved."""

    def __init__(self) -> None:
        self._held = False

    def hold(self) -> None:
        """From now on no signal interrupts: the recording is being saved."""
        self._held = True

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Take a signal."""
        if self._held:
            print("saving the recording, wait", file=sys.stderr)
            return
        self._held = True
        raise KeyboardInterrupt(signal.Signals(number).name)


@contextmanager
def ending() -> Iterator[Ending]:
    """Take Ctrl-C, SIGTERM and SIGHUP alike, and put back what took them before; only a main thread can."""
    taken = Ending()
    if threading.current_thread() is not threading.main_thread():
        yield taken
        return
    before = {number: signal.signal(number, taken) for number in ENDING}
    try:
        yield taken
    finally:
        for number, handler in before.items():
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)
