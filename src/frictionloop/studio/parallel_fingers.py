"""The row of twelve fingers: made when a page asks for it, kept in step with the session, gone when no page looks."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from typing import Any

import numpy as np

from frictionloop.live.live_engines import CROWD, Crowd
from frictionloop.live.live_session import Block, Session
from frictionloop.loop.kernel.tile_compatibility import structure
from frictionloop.parameters import System
from frictionloop.physics.fingers import fingers
from frictionloop.quantities import FrictionloopError
from frictionloop.studio.connections import why_of
from frictionloop.studio.frames import CROWD_FRAME, Frame, pack
from frictionloop.studio.live_numbers import LEAST_S, WINDOW_S, slides

PEOPLE = 12
POPULATION_SEED = 0
"""Seed of the population that another finger is drawn from."""
_ASKED, _OPEN, _CLOSED, _BEYOND = range(len(CROWD))


class Twelve:
    """The first twelve fingers of the population under the stroke of a session."""

    def __init__(self, session: Session) -> None:
        self._session, self._people = session, fingers(PEOPLE, POPULATION_SEED)
        self._crowd: Crowd | None = None
        self._making: asyncio.Task[Crowd] | None = None
        self._system: System | None = None
        self._why, self._number = "", 0
        self._kept: deque[np.ndarray] = deque()
        self._part: list[np.ndarray] = []

    def rest(self) -> None:
        """Let everybody go."""
        self._crowd = self._system = None
        self._kept.clear()
        self._part.clear()

    def follow(self, block: Block) -> bytes | None:
        """Return what everybody felt along a stretch of the session as a message; None until a whole block is there."""
        if not self._there():
            return None
        assert self._crowd is not None
        self._part.append(block.rows)
        if sum(rows.shape[1] for rows in self._part) < self._session.block_ticks:
            return None  # a block that ended early, at a sample of the pointer
        stretch, self._part = np.concatenate(self._part, axis=1), []
        try:
            told = self._crowd.advance(stretch)
        except FrictionloopError as error:
            self._crowd, self._why = None, str(error)
            return None
        self._kept.append(told)
        while len(self._kept) * told.shape[1] > WINDOW_S * self._crowd.rate_hz:
            self._kept.popleft()
        rows = told[:, -1:]  # one value of a block, about one for each column of the small pictures
        packed = np.vstack([rows[_ASKED, :, :1].T, rows[_OPEN].T, rows[_CLOSED].T])
        self._number += 1
        ticks, rate = told.shape[1], self._crowd.rate_hz
        end = block.first_tick + block.rows.shape[1]
        return pack(Frame(self._number, end / rate, math.nan, ticks / rate, packed), CROWD_FRAME)

    def _there(self) -> bool:
        """Make the people, or give them the System in force; tell whether they are there."""
        system = self._session.engine.system
        if self._making is not None:
            if not self._making.done():
                return False
            self._made(self._making)
        if system is self._system:
            return self._crowd is not None
        self._kept.clear()
        self._part.clear()
        try:
            if self._crowd is None or self._system is None or structure(system) != structure(self._system):
                # Another structure may have to be compiled, which takes seconds: not in the time of the session.
                self._crowd = None
                self._making = asyncio.ensure_future(asyncio.to_thread(Crowd, system, self._people))
            else:
                self._crowd.change(system)
        except FrictionloopError as error:
            self._crowd, self._why = None, str(error)
        self._system = system
        return self._crowd is not None

    def _made(self, task: asyncio.Task[Crowd]) -> None:
        self._making, self._why = None, ""
        try:
            self._crowd = task.result()
        except Exception as error:  # the row must not take the session with it, whatever it died of
            self._why = why_of(error)
        if self._crowd is not None and self._system is not self._session.engine.system:
            self._crowd = self._system = None

    def summary(self) -> dict[str, Any]:
        """Return what pages are told of everybody in the last two seconds: errors (N) and share out of reach."""
        state = "ready" if self._crowd is not None else "making" if self._making is not None else "refused"
        return {"type": "crowd", "state": state, "why": self._why, "people": self._each() if self._crowd else []}

    def _each(self) -> list[dict[str, float | None]]:
        crowd = self._crowd
        assert crowd is not None
        nominal = [person["friction.nominal_n"] for person in crowd.people]
        nothing = [{"nominal_n": each, "open_error_n": None, "closed_error_n": None} for each in nominal]
        if not self._kept:
            return nothing
        rows = np.concatenate(self._kept, axis=1)
        ahead = sum(part.shape[1] for part in self._part)
        own = self._session.last((rows.shape[1] + ahead) / crowd.rate_hz)
        own = own[:, : own.shape[1] - ahead]
        rows = rows[:, rows.shape[1] - own.shape[1] :]
        touches = self._session.engine.system.touch.load.touch_n
        sliding = slides(own[0].astype(float), own[1], crowd.rate_hz, touches)
        if sliding.sum() < LEAST_S * crowd.rate_hz:
            return nothing
        counted = rows[:, sliding].astype(float)
        errors = np.sqrt(np.mean((counted[[_OPEN, _CLOSED]] - counted[_ASKED]) ** 2, axis=1))
        beyond = counted[_BEYOND].mean(axis=0)
        return [
            {"nominal_n": f, "open_error_n": float(o), "closed_error_n": float(c), "beyond": float(s)}
            for f, o, c, s in zip(nominal, *errors, beyond, strict=True)
        ]
