"""The pages that are connected, by role, and messages to them from the thread of the session."""

from __future__ import annotations

import asyncio
import json
import threading
from typing import Any

from frictionloop.studio.guest import Guest

PARTICIPANT, EXPERIMENTER = "participant", "experimenter"


class Hub:
    """Pages by role; each page that comes is told what the last ones were told that still holds."""

    def __init__(self) -> None:
        self._guests: dict[str, list[Guest]] = {PARTICIPANT: [], EXPERIMENTER: []}
        self._holds: dict[tuple[str, str], dict[str, Any]] = {}
        self._lock = threading.RLock()
        self.loop: asyncio.AbstractEventLoop | None = None
        """Loop of the server, once it runs."""

    def join(self, role: str, guest: Guest) -> None:
        """Take in a page."""
        with self._lock:
            for (of, _), message in self._holds.items():
                if of == role:
                    guest.put(message)
            self._guests[role].append(guest)

    def leave(self, role: str, guest: Guest) -> None:
        """Let a page go."""
        with self._lock:
            self._guests[role].remove(guest)

    def pages(self, role: str) -> int:
        """Return how many pages of a role are connected."""
        return len(self._guests[role])

    def tell(self, role: str, kind: str, **told: Any) -> None:
        """Tell the pages of a role something that holds until it is told anew; may be called from any thread."""
        message = {"type": kind, **told}
        with self._lock:
            self._holds[(role, kind)] = message
            self._put(role, message)

    def pass_on(self, role: str, kind: str, **told: Any) -> None:
        """Tell the pages of a role something of the moment: a slow page may miss it."""
        with self._lock:
            self._put(role, json.dumps({"type": kind, **told}).encode())

    def _put(self, role: str, message: bytes | dict[str, Any]) -> None:
        if self.loop is not None and not self.loop.is_closed():
            for guest in self._guests[role]:
                self.loop.call_soon_threadsafe(guest.put, message)
