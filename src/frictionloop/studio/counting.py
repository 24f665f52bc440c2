"""The numbers of the last seconds, counted beside the session: they take the time of a block."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from frictionloop.live.session import Session
from frictionloop.studio import background
from frictionloop.studio.numbers import WINDOW_S, numbers_of

SETTLES_S = 0.5
"""Time in which the first page shows its first picture before anything is counted, or loaded for it (assumed)."""


class Counting:
    """Counts when asked to, unless it does so already.

    Parameters
    ----------
    session : Session
        Whose numbers they are.
    tell : callable
        Takes the message.
    """

    def __init__(self, session: Session, tell: Callable[[dict[str, Any]], None]) -> None:
        self._session, self._tell = session, tell
        self._task: asyncio.Task[None] | None = None
        self._asked_s = math.inf

    def renew(self, now_s: float) -> None:
        """Count what there is now; nothing for `SETTLES_S` after it was asked first.

        Raises
        ------
        Exception
            What ended the count before.
        """
        self._asked_s = min(self._asked_s, now_s)
        if now_s - self._asked_s < SETTLES_S or (self._task is not None and not self._task.done()):
            return
        if self._task is not None:
            self._task.result()
        self._task = asyncio.get_running_loop().create_task(self._count())

    async def _count(self) -> None:
        engine = self._session.engine
        rows, touches = self._session.last(WINDOW_S), engine.system.touch.load.touch_n
        self._tell({"type": "numbers"} | await asyncio.to_thread(_numbers, rows, engine.rate_hz, touches))


def _numbers(rows: np.ndarray, rate_hz: float, touches_n: float) -> dict[str, float | None]:
    background.load()
    return numbers_of(rows, rate_hz, touches_n)
