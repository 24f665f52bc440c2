"""The map of what lies on the plate, drawn beside the session: a rough texture takes a second."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from frictionloop.live.session import Session
from frictionloop.parameters import System
from frictionloop.rendering.source import EffectSource
from frictionloop.studio.plate import map_of


class Drawing:
    """Keeps the map of a session's effect; while one is drawn, only the newest of those that come waits.

    Parameters
    ----------
    session : Session
        Whose effect it is.
    tell : callable
        Takes a map that is new, as a message.
    """

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
