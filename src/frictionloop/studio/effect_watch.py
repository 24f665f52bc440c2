"""Keeps what pages are told of the effect that will not arrive: looked at anew when something has changed."""

from __future__ import annotations

import asyncio
from typing import Any

from frictionloop.live.session import Session
from frictionloop.parameters import System
from frictionloop.studio import background

WAITS_S = 0.3
"""How long nothing has to change before it is computed: a slider in the hand would only be in its own way."""


class EffectWatch:
    """Keeps a preview of what lies on the plate, computed beside the session.

    Parameters
    ----------
    session : Session
        Whose System, speed and load are tried.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._asked: tuple[Any, ...] | None = None
        self._since_s = 0.0
        self._task: asyncio.Task[dict[str, Any]] | None = None
        self.told: dict[str, Any] | None = None
        """The last message, None before the first."""

    def follow(self, now_s: float) -> dict[str, Any] | None:
        """Look whether something has changed, and return a message when a preview is done."""
        session = self._session
        wanted = session.engine.system, session.ghost.speed_mm_s, session.load_n
        if wanted != self._asked:
            self._asked, self._since_s, self.told = wanted, now_s, None
        if self._task is not None:
            if not self._task.done():
                return None
            done, self._task = self._task.result(), None
            if done.pop("of") == wanted:
                self.told = done
                return done
        if self.told is None and now_s - self._since_s >= WAITS_S:
            self._task = asyncio.ensure_future(asyncio.to_thread(_foreseen, *wanted))
        return None


def _foreseen(system: System, speed_mm_s: float, load_n: float) -> dict[str, Any]:
    background.load()
    from frictionloop.studio.effect_feasibility import previewed

    return previewed(system, speed_mm_s, load_n)
