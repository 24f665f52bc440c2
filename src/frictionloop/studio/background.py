"""What is done beside the session: what a page needs is loaded, its numbers counted, the effect drawn and tried."""

from __future__ import annotations

import asyncio
import gc
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from threading import Lock
from typing import Any

import numpy as np

from frictionloop.live.live_session import Session
from frictionloop.parameters import System
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.studio.effect_pictures import map_of
from frictionloop.studio.live_numbers import WINDOW_S, numbers_of

MODULES = (
    "scipy.signal",
    "frictionloop.loop.companion_runs",
    "frictionloop.studio.effect_feasibility",
    "frictionloop.studio.effect_uploads",
)
"""They bring filters, Datasets and files along."""
YIELDS_S = 0.5e-3
"""After how long a thread that works beside the session gives way to it (assumed: a tenth of a block)."""
_loading = Lock()


def load() -> None:
    """Load all of it, which takes a second the first time; for a thread beside the session."""
    with _loading:  # two threads that load what loads one another would find half of it
        if all(name in sys.modules for name in MODULES):
            return
        for name in MODULES:
            import_module(name)
        if gc.get_freeze_count():  # which counts them one by one, in 20 ms
            gc.freeze()


@contextmanager
def starting() -> Iterator[None]:
    """Let a session start and run: no search for garbage before it is `started`, and threads beside it that give way.

    The search through all that is loaded takes 0.2 s of the start, and stands a session still for 0.15 s.
    """
    before = sys.getswitchinterval()
    gc.disable()
    sys.setswitchinterval(YIELDS_S)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
        gc.enable()


def started() -> None:
    """Take note that a session runs, if it was `starting`: what is there now stays, and is never searched again."""
    if not gc.isenabled():
        gc.freeze()
        gc.enable()


SETTLES_S = 0.5
"""Time in which the first page shows its first picture before anything is counted, or loaded for it (assumed)."""


class Counting:
    """Counts when asked to, unless it does so already."""

    def __init__(self, session: Session, tell: Callable[[dict[str, Any]], None]) -> None:
        self._session, self._tell = session, tell
        self._task: asyncio.Task[None] | None = None
        self._asked_s = math.inf

    def renew(self, now_s: float) -> None:
        """Count what there is now; nothing for `SETTLES_S` after it was asked first."""
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
    load()
    return numbers_of(rows, rate_hz, touches_n)


class Drawing:
    """Keeps the map of a session's effect; while one is drawn, only the newest of those that come waits."""

    def __init__(self, session: Session, tell: Callable[[bytes], None]) -> None:
        self._session, self._tell = session, tell
        self._of: Any = None
        self._map = b""
        self._task: asyncio.Task[bytes] | None = None

    def renew(self) -> None:
        """Draw what lies on the plate now, unless it is drawn already or being drawn."""
        if self._of != _seen(self._session.engine.system) and (self._task is None or self._task.done()):
            self._task = asyncio.get_running_loop().create_task(self._draw())

    async def drawn(self) -> bytes:
        """Return the map of what lies on the plate."""
        self.renew()
        if self._task is not None and not self._task.done():
            await asyncio.shield(self._task)
        return self._map

    async def _draw(self) -> bytes:
        while self._of != (wanted := _seen(system := self._session.engine.system)):
            found = await asyncio.to_thread(map_of, system)
            self._of, self._map = wanted, found
            if wanted == _seen(self._session.engine.system):
                self._tell(found)
        return self._map


def _seen(system: System) -> tuple[Any, float]:
    """Return what decides on the map; the line of the stroke does not."""
    source = system.setpoint
    return source.effect if isinstance(source, EffectSource) else None, system.touch.load.length_mm


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
    load()
    from frictionloop.studio.effect_feasibility import previewed

    return previewed(system, speed_mm_s, load_n)
