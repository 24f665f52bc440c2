"""A page that is connected: what waits for it, and what it wants to be told."""

from __future__ import annotations

import asyncio
import secrets
from collections import deque
from typing import Any

WAITING = 64
"""Messages that wait for a slow page; the oldest frames are then dropped (a third of a second)."""


class Guest:
    """A page that is connected."""

    def __init__(self, may_drive: bool) -> None:
        self.may_drive, self.listens, self.lost = may_drive, False, 0
        self.crowd = False
        """Whether it looks at the row of fingers."""
        self.ahead = False
        """Whether it is told what of the effect will not arrive."""
        self.key = secrets.token_urlsafe(16)
        """Tells its requests from those of other pages."""
        self._waiting: deque[bytes | dict[str, Any]] = deque()
        self._there = asyncio.Event()

    def put(self, message: bytes | dict[str, Any]) -> None:
        """Let a message wait to be sent; the oldest frame goes when too many wait."""
        if len(self._waiting) >= WAITING:
            for place, old in enumerate(self._waiting):
                if isinstance(old, bytes):
                    del self._waiting[place]
                    self.lost += 1
                    break
            else:
                self._waiting.popleft()
        self._waiting.append(message)
        self._there.set()

    async def next(self) -> bytes | dict[str, Any]:
        """Return the next message to send."""
        while not self._waiting:
            self._there.clear()
            await self._there.wait()
        return self._waiting.popleft()
