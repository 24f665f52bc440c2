"""A live session: one finger, one engine, in real time, and the last 30 s of it, which may be saved as a run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from frictionloop.live.live_engines import CHANNELS, Engine
from frictionloop.live.pointer_motion import Ghost, LiveFinger, PointerPath, Sample
from frictionloop.loop.record import VARIABLES, provenance
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr


BLOCKS_HZ = 200.0
"""Blocks per second; one more for each sample of a pointer."""
SPARSE = 5
"""Ticks per row of a frame for the eye, and that a block ends early by: a millisecond at 5 kHz."""
CATCH_UP_S = 0.5
"""What a stalled session makes good; the rest of the time is dropped, and counted."""
KEPT_S = 30.0
"""What is kept of the past."""
GONE_S = 0.25
"""A finger whose page is silent for so long has left the plate."""


class Block(NamedTuple):
    """A stretch of the session."""

    first_tick: int
    rows: np.ndarray
    """`CHANNELS` over the ticks, float32, shape (channels, ticks)."""
    reached_ms: float
    """Page time of the newest pointer event in it, NaN without."""


class Session:
    """A finger that is moved by a pointer, or by itself, over an engine; time is an argument of `step`."""

    def __init__(self, engine: Engine) -> None:
        self.engine, self.finger, self.ghost = engine, LiveFinger(), Ghost()
        self.pointer, self.ghost_on, self.stopped = PointerPath(), True, False
        self.ticks = 0
        """Ticks since the beginning."""
        self.changed_tick = 0
        """Tick at which the System last changed."""
        self.dropped_s = 0.0
        """Time that the session could not make good."""
        self.load_n = 0.5
        """Load of a finger whose pointer tells no pressure, and of the ghost."""
        self.line_mm = 0.0
        """Height of the line that the finger strokes along: where it landed last."""
        self.driven = True
        """Whether a page drives; else nothing moves, the ghost neither."""
        self._down, self._heard_s, self._begun_s = False, -math.inf, math.nan
        self._size()

    def _size(self) -> None:
        rate = self.engine.rate_hz
        self.block_ticks = max(round(rate / BLOCKS_HZ), 1)
        self._kept = np.full((len(CHANNELS), round(KEPT_S * rate)), np.nan, np.float32)

    def touch(self, now_s: float, events: np.ndarray) -> bool:
        """Take pointer events and return whether the finger has landed with them.

        Their rows are page time (ms), x (mm), y (mm) and load (N; NaN where the pointer has none). What a page said
        long ago, which was stopped since, moves nothing.
        """
        heard_s = self.pointer.heard_s(now_s, float(events[-1, 0]))
        if now_s - heard_s > GONE_S:
            return False
        events = np.where(np.isnan(events), self.load_n, events)
        landed = not self._down
        if landed:
            self.pointer.clear()
            self.line_mm = float(events[0, 2])
        self._down, self._heard_s = True, heard_s
        self.pointer.add(events)
        return landed

    def lift(self) -> None:
        """Take the finger off the plate."""
        self._down = False

    def present(self, now_s: float) -> None:
        """Take note that the driving page is there."""
        self.driven = True

    def leave(self) -> None:
        """Let the driving page go: the finger leaves the plate, and nothing moves until a page drives again.

        The next one has a clock of its own.
        """
        self._down, self.driven, self.pointer = False, False, PointerPath()

    def stop(self) -> None:
        """Bring the plate to rest: the finger leaves it, and nothing moves until `go`."""
        self._down, self.stopped = False, True

    def go(self) -> None:
        """Let the finger move again."""
        self.stopped = False

    def arm(self, state: str) -> None:
        """Let the loop of a device run; without one there is nothing to arm."""
        raise FrictionloopError("arm: no device", "NO-DEVICE")

    def clear(self) -> None:
        """Clear a fault of a device; without one there is none."""
        raise FrictionloopError("clear: no device", "NO-DEVICE")

    def device_status(self) -> dict[str, object] | None:
        """Return what pages are told of a device, None without one."""
        return None

    def refused(self) -> list[str]:
        """Return what a device has refused of changes since the last call, in words."""
        return []

    def change(self, system: System) -> bool:
        """Put a System in force; return whether the loop went on without a restart."""
        rate = self.engine.rate_hz
        went_on = self.engine.change(system)
        if self.engine.rate_hz != rate:
            self.ticks, self._begun_s = 0, math.nan
            self._size()
        self.changed_tick = self.ticks
        return went_on

    def step(self, now_s: float) -> list[Block]:
        """Go on to a time and return the blocks since the last call: none if it is early."""
        rate = self.engine.rate_hz
        if math.isnan(self._begun_s):
            self._begun_s = now_s - self.ticks / rate
        behind_s = self._behind_s(now_s, self.ticks, CATCH_UP_S)
        done, now = [], self.ticks + int(behind_s * rate + 1e-6)
        while (end := self._end()) <= now:
            done.append(self._block(end, now_s))
        return done

    def _behind_s(self, now_s: float, ticks: int, most_s: float, slack_s: float = 0.0) -> float:
        """Return how far ticks are behind, s; what is more than ``most_s``, by more than the slack, is dropped."""
        behind_s = now_s - self._begun_s - ticks / self.engine.rate_hz
        if behind_s <= most_s + slack_s:
            return behind_s
        self.dropped_s += behind_s - most_s
        self._begun_s += behind_s - most_s
        return most_s

    def _end(self) -> int:
        """Return the tick at which the next block ends: on the grid of blocks, or at a pointer's sample before that.

        The loop then knows of the sample without waiting for the grid. A pointer of many samples ends one block of two.
        """
        grid = (self.ticks // self.block_ticks + 1) * self.block_ticks
        if not self._down or self.ticks % self.block_ticks:
            return grid
        rate = self.engine.rate_hz
        next_s = self.pointer.next_s(self._begun_s + self.ticks / rate)
        rows = math.ceil(((next_s - self._begun_s) * rate - self.ticks) / SPARSE) if next_s < math.inf else grid
        return min(self.ticks + SPARSE * rows, grid)

    def due_s(self, now_s: float) -> float:
        """Return the time until the next block is due, s: from 0 to a block."""
        if math.isnan(self._begun_s):
            return 0.0
        due = self._begun_s + self._end() / self.engine.rate_hz - now_s
        return min(max(due, 0.0), 1.0 / BLOCKS_HZ)

    def _block(self, end: int, now_s: float) -> Block:
        ticks, rate = end - self.ticks, self.engine.rate_hz
        if now_s - self._heard_s > GONE_S:
            self._down = False
        wanted = self._wanted(self._begun_s + end / rate, ticks / rate)
        path = self.finger.block(wanted, ticks, rate)
        rows = self.engine.advance(path).astype(np.float32)
        return self._keep(rows)

    def _keep(self, rows: np.ndarray) -> Block:
        first, (_, size), ticks = self.ticks, self._kept.shape, rows.shape[1]
        self._kept[:, np.arange(first, first + ticks) % size] = rows
        self.ticks += ticks
        return Block(first, rows, self.pointer.reached_ms if self._down else math.nan)

    def _wanted(self, at_s: float, span_s: float) -> Sample | None:
        if self.stopped or not self.driven:
            return None
        if self._down:
            return self.pointer.at(at_s)
        if self.ghost_on:
            return Sample(at_s, self.ghost.move(span_s), self.line_mm, self.load_n)
        return None

    def last(self, seconds: float = KEPT_S) -> np.ndarray:
        """Return `CHANNELS` of the last seconds, shape (channels, ticks), at most `KEPT_S`."""
        size = self._kept.shape[1]
        count = min(round(seconds * self.engine.rate_hz), self.ticks, size)
        return self._kept[:, np.arange(self.ticks - count, self.ticks) % size]


RUN = {
    "f_r": "asked_n",
    "f_a": "closed_n",
    "f_m": "measured_n",
    "a": "closed_um",
    "saturated": "saturated",
    "load": "load_n",
    "limit": "limit_n",
    "floor": "floor_n",
}
"""Variables of a run by the channel that holds them."""
BESIDE = {"f_a_open": "open_n", "a_open": "open_um"}
"""What the loop beside it adds, which is open."""


def recorded(session: Session, seconds: float = KEPT_S) -> xr.Dataset:
    """Return what a session keeps as a run that ``fl.save`` writes and ``fl.load`` reads.

    The variables are those of ``fl.simulate``, in float32; ``f_a_open`` and ``a_open`` are of the open loop beside it.
    The System is the one now in force: ``changed_at_s`` tells when it last changed.

    Parameters
    ----------
    session : Session
        What ran.
    seconds : float
        How much of it, s, at most `KEPT_S`.
    """
    import xarray as xr

    rows, rate = session.last(seconds), session.engine.rate_hz
    told = dict(zip(CHANNELS, rows, strict=True))
    first = session.ticks - rows.shape[1]
    time = np.arange(rows.shape[1]) / rate
    data = {
        name: xr.Variable("time", told[channel] != 0 if name == "saturated" else told[channel], _attrs(name, channel))
        for name, channel in {**RUN, **BESIDE}.items()
    }
    data["position"] = xr.Variable("time", 1e-3 * told["x_mm"], _attrs("position", "x_mm"))
    coordinate = {"time": xr.Variable("time", time, {"units": "s", "long_name": "time"})}
    more = {"began_at_s": first / rate, "changed_at_s": session.changed_tick / rate}
    return xr.Dataset(data, coordinate, provenance(session.engine.system, **more) | {"source": session.engine.source})


def _attrs(name: str, channel: str) -> dict[str, str]:
    units, meaning = VARIABLES.get(name, CHANNELS[channel])
    return {"units": units, "long_name": meaning}
