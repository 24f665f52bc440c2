"""Who is connected, who drives, and the task that keeps the session in time."""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Callable, Coroutine, Sequence
from contextlib import suppress
from typing import Any

from frictionloop.live.live_session import SPARSE, Block, Session
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError
from frictionloop.studio.background import Counting, Drawing, EffectWatch
from frictionloop.studio.connections import Guest, why_of
from frictionloop.studio.effect_pictures import read_along
from frictionloop.studio.frames import events_in, frame_of, pack
from frictionloop.studio.parallel_fingers import Twelve
from frictionloop.studio.parameter_panels import system_message

TOLD_EVERY_S = 0.2
"""How often numbers and status go out."""
MOST_RUNS = 8
"""Recorded runs that are kept for the pages; the oldest goes (assumed)."""
UNDONE = 100
"""Changes that can be undone."""


class Room:
    """The session and its guests."""

    def __init__(self, session: Session, clock: Callable[[], float] = time.monotonic) -> None:
        self.session, self.clock, self.twelve, self.effect_watch = session, clock, Twelve(session), EffectWatch(session)
        self.drawing, self.counting = Drawing(session, self.tell), Counting(session, self.tell)
        self.guests: list[Guest] = []
        self.driver: Guest | None = None
        self.before: deque[System] = deque(maxlen=UNDONE)
        """Systems that were in force before, the last one last."""
        self.before_tour: System | None = None
        """What was in force before the tour; None while nobody is on it."""
        self.runs: deque[dict[str, Any]] = deque(maxlen=MOST_RUNS)
        """Recorded runs that pages can play, the newest first."""
        self.dead = ""
        """Why the engine has stopped, empty while it runs."""
        self._number, self._told_s = 0, -math.inf
        self._doing: set[asyncio.Task[None]] = set()

    def redraw(self) -> None:
        """Let the map of the effect be drawn where it is another one; without a server nobody looks at it."""
        with suppress(RuntimeError):
            self.drawing.renew()

    def later(self, work: Coroutine[Any, Any, None]) -> None:
        """Let something be done beside the session."""
        task = asyncio.get_running_loop().create_task(work)
        self._doing.add(task)
        task.add_done_callback(self._doing.discard)

    def join(self, guest: Guest) -> None:
        """Take in a page; it drives if nobody does and it may."""
        self.guests.append(guest)
        if self.driver is None and guest.may_drive:
            self.driver = guest
            self.session.present(self.clock())
        self.tell_status()

    def leave(self, guest: Guest) -> None:
        """Let a page go; the finger of the driving page leaves the plate."""
        self.guests.remove(guest)
        if guest is self.driver:
            self.session.leave()
            self.driver = None
            self.end_tour()
        self.tell_status()

    def take(self, guest: Guest) -> None:
        """Let a page drive."""
        if not guest.may_drive:
            raise FrictionloopError("this page may watch only")
        if self.driver is not None and guest is not self.driver:
            self.session.leave()  # whoever takes over arms a device anew
            self.end_tour()
        self.driver = guest
        self.session.present(self.clock())
        self.tell_status()

    def put(self, system: System, remember: bool = True) -> None:
        """Put a System in force, and tell every page; what was there can be had again by undo."""
        before = self.session.engine.system
        went_on = self.session.change(system)
        if remember:
            self.before.append(before)
        self.redraw()
        self.tell(system_message(system) | {"restarted": not went_on})

    def end_tour(self) -> None:
        """Put in force again what was before a tour, whose page ends it or goes: its loop has been compiled."""
        if (before := self.before_tour) is not None:
            self.before_tour = None
            for task in self._doing:  # a step whose loop is still being compiled comes too late
                task.cancel()
            self.put(before)

    def heard(self, guest: Guest) -> None:
        """Take note that a page is there: a device is switched off when the driving page falls silent."""
        if guest is self.driver:
            self.session.present(self.clock())

    def touched(self, guest: Guest, data: bytes) -> None:
        """Take the pointer events of a page."""
        if self.driver is None and guest.may_drive:
            self.take(guest)
        if guest is not self.driver or self.dead or not self.session.touch(self.clock(), events_in(data)):
            return
        # The effect is read along the line on which the finger has landed, where that is another force.
        if (along := read_along(self.session.engine.system, self.session.line_mm)) is not None:
            self.session.change(along)

    def status(self) -> dict[str, Any]:
        """Return what every page is told of the session."""
        session = self.session
        state = "dead" if self.dead else "stopped" if session.stopped else "running"
        return {
            "type": "status", "state": state, "why": self.dead, "source": session.engine.source,
            "pages": len(self.guests), "driven": self.driver is not None,
            "dropped_s": round(session.dropped_s, 2), "ghost": session.ghost_on,
            "ghost_mm_s": session.ghost.speed_mm_s, "load_n": session.load_n,
            "line_mm": session.line_mm, "device": session.device_status(),
        }  # fmt: skip

    def tell_status(self) -> None:
        """Tell every page how things stand, and what it may do."""
        for guest in self.guests:
            guest.put(self.status() | {"drives": guest is self.driver, "may_drive": guest.may_drive})

    def tell(self, message: bytes | dict[str, Any], guests: Sequence[Guest] | None = None) -> None:
        """Tell every page something, or these alone."""
        for guest in self.guests if guests is None else guests:
            guest.put(message)

    async def run(self) -> None:
        """Keep the session in time; what ends it is told to every page."""
        try:
            while True:
                self.step()
                if self.clock() - self._told_s >= TOLD_EVERY_S:
                    await asyncio.sleep(0)  # frames go out before what takes its time
                    self.tell_beside()
                await asyncio.sleep(self.session.due_s(self.clock()))
        except Exception as error:  # a dead task must be seen, whatever it died of
            self.die(why_of(error))

    def die(self, why: str) -> None:
        """Say that the engine has stopped."""
        self.dead = why
        self.tell_status()

    def step(self) -> None:
        """Go on to now, and send what is new."""
        for block in self.session.step(self.clock()):
            self._send(block)
        for why in self.session.refused():
            self.tell({"type": "refused", "why": why})
            self.tell(system_message(self.session.engine.system))
            self.redraw()

    def tell_beside(self) -> None:
        """Tell how things stand, the numbers, the row of fingers, and what will not arrive."""
        now_s = self._told_s = self.clock()
        self.tell_status()
        if self.guests:
            self.counting.renew(now_s)
        if onlookers := self._onlookers:
            self.tell(self.twelve.summary(), onlookers)
        if any(guest.ahead for guest in self.guests) and (told := self.effect_watch.follow(now_s)) is not None:
            self.tell(told, [guest for guest in self.guests if guest.ahead])

    def _send(self, block: Block) -> None:
        self._number += 1
        packed: dict[bool, bytes] = {}
        for guest in self.guests:
            every = 1 if guest.listens else SPARSE  # for the ear every tick travels
            if guest.listens not in packed:
                packed[guest.listens] = pack(frame_of(block, self._number, self.session.engine.rate_hz, every))
            guest.put(packed[guest.listens])
        if not (onlookers := self._onlookers):
            self.twelve.rest()
        elif (crowd := self.twelve.follow(block)) is not None:
            self.tell(crowd, onlookers)

    @property
    def _onlookers(self) -> list[Guest]:
        """Pages that look at the row of fingers."""
        return [guest for guest in self.guests if guest.crowd]
