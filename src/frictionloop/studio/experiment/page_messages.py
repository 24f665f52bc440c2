"""What the pages of an experiment say and are told: the server's loop takes it, the session's thread finds it here."""

from __future__ import annotations

import asyncio
import json
import queue
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.session_folder import now
from frictionloop.experiments.trial_records import number_of
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.studio.connections import Guest

PARTICIPANT, EXPERIMENTER = "participant", "experimenter"
TIMING = ("trial", "at_s", "sd_s")
"""Numbers that come with an answer."""


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


LONGEST_NOTE = 500
"""Characters of a note (assumed)."""


class Hearing:
    """Answers, and what the experimenter does."""

    def __init__(self, protocol: Protocol, log: Callable[..., None]) -> None:
        self.protocol, self.hub, self._log = protocol, Hub(), log
        self.answers: queue.Queue[tuple[int, str, float, float]] = queue.Queue()
        """Trial, answer, when it was given (s), and how well that is known (s)."""
        self.ready, self.going = threading.Event(), threading.Event()
        self.going.set()
        self.aborted, self.trial, self.masking_db = False, 0, protocol.masking_db

    def hear(self, role: str, message: Mapping[str, Any]) -> None:
        """Take what a page says."""
        what = message.get("do")
        if what == "ready":
            self.ready.set()
        elif what == "answer":
            self._take(message)
        elif role != EXPERIMENTER:
            raise must_be("do", what, "ready, answer or clock")
        elif what == "pause":
            self.going.clear()
            self.status("paused")
            self._log("pause", time=now(), trial=self.trial)
        elif what == "go":
            self.going.set()
            self.status("running")
            self._log("go on", time=now(), trial=self.trial)
        elif what == "note":
            text = str(message.get("text", "")).strip()
            if not 0 < len(text) <= LONGEST_NOTE:
                raise must_be("note", len(text), f"1 to {LONGEST_NOTE}", "characters")
            self._log("note", time=now(), trial=self.trial, text=text)
            self.hub.pass_on(EXPERIMENTER, "noted", text=text, trial=self.trial)
        elif what == "abort":
            self.aborted = True
            self._log("abort", time=now(), trial=self.trial)
            self.status("aborting")
        elif what == "masking":
            self._mask(message.get("db"))
        else:
            raise must_be("do", what, "pause, go, note, abort or masking")

    def connected(self) -> None:
        """Tell the experimenter whether the participant's page is there."""
        self.hub.tell(EXPERIMENTER, "pages", participant=self.hub.pages(PARTICIPANT))

    def _take(self, message: Mapping[str, Any]) -> None:
        answer, heard = str(message.get("answer", "")), time.monotonic()
        choices = self.protocol.choices
        try:
            trial, at_s, sd_s = int(message["trial"]), float(message["at_s"]), float(message["sd_s"])
        except (KeyError, TypeError, ValueError):
            wrong = [name for name in TIMING if not isinstance(message.get(name), (int, float))]
            raise FrictionloopError(f"answer: needs {', '.join(wrong or TIMING)} as numbers") from None
        if not choices:
            number_of(self.protocol.task, answer)
        elif answer not in choices:
            raise FrictionloopError(f"answer = {answer!r}: accepted: {', '.join(choices)}")
        # A page whose clock is not known, or that says it answered later than it was heard, counts as heard.
        if not (0.0 <= sd_s < 1.0 and heard - 10.0 < at_s <= heard):
            at_s, sd_s = heard, max(sd_s, 0.0) if 0.0 <= sd_s < 1.0 else 0.1
        self.answers.put((trial, answer, at_s, sd_s))

    def _mask(self, level: Any) -> None:
        if level is not None and not (isinstance(level, (int, float)) and -60.0 <= level <= 0.0):
            raise must_be("masking: db", level, "-60 to 0, or none")
        self._log("adjusted", time=now(), what="masking_db", value=level, before=self.masking_db, why="experimenter")
        self.masking_db = level
        for role in (PARTICIPANT, EXPERIMENTER):
            self.hub.tell(role, "masking", db=level)

    def status(self, state: str, why: str = "") -> None:
        """Tell the experimenter how the session stands."""
        self.hub.tell(EXPERIMENTER, "status", state=state, why=why)
