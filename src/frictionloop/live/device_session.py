"""A live session on a device: armed by the driving page, and off as soon as that page is gone."""

from __future__ import annotations

import math

import numpy as np

from frictionloop.live.device_engine import DeviceEngine
from frictionloop.live.live_session import BLOCKS_HZ, GONE_S, Block, Session

SILENT_S = 0.15
"""A driving page that says nothing for so long is gone: with the 0.1 s of the board's ramp it is at rest in 0.3 s."""
STALLED_S = 0.05
"""A session that was not called for so long cannot tell who was silent meanwhile (assumed)."""
BLOCKS = {"simulated": 20, "emulated": 1}
"""What a simulated board makes good at once, in blocks (assumed).

An emulated one may be slower than time, and pages must be heard meanwhile.
"""
WITHIN = 0.95
"""Share of what the position sensor reads within which the finger is kept: at its end the board would find a fault."""


class DeviceSession(Session):
    """A session whose ticks come from a device."""

    engine: DeviceEngine

    def __init__(self, engine: DeviceEngine) -> None:
        super().__init__(engine)
        self.ghost_on = engine.is_paced
        self._reach_mm = WITHIN * engine.reach_mm
        self.ghost.stroke_mm = min(self.ghost.stroke_mm, 1.5 * self._reach_mm)
        self._driver_s, self._called_s = -math.inf, -math.inf
        self._pending: list[np.ndarray] = []
        self._asked = 0  # ticks of a simulated board

    def present(self, now_s: float) -> None:
        """Take note that the driving page is there."""
        super().present(now_s)
        self._driver_s = now_s

    def leave(self) -> None:
        """Let the driving page go: the plate comes to rest."""
        super().leave()
        if self.engine.armed != "idle":
            self.engine.disarm()

    def stop(self) -> None:
        """Bring the plate to rest."""
        super().stop()
        self.engine.disarm()

    def arm(self, state: str) -> None:
        """Let the loop of the device run, ``"open"`` or ``"closed"``."""
        self.engine.arm(state)
        self.go()

    def clear(self) -> None:
        """Clear a fault of the device."""
        self.engine.clear()

    def device_status(self) -> dict[str, object] | None:
        """Return what pages are told of the device."""
        return self.engine.device_status()

    def refused(self) -> list[str]:
        """Return what the device has refused of changes since the last call, in words."""
        told, self.engine.refused = self.engine.refused, []
        return told

    def step(self, now_s: float) -> list[Block]:
        """Go on to a time and return the blocks whose ticks have come in."""
        if now_s - self._called_s > STALLED_S:
            self._driver_s = max(self._driver_s, now_s - STALLED_S) if math.isfinite(self._driver_s) else now_s
        self._called_s = now_s
        if self.engine.armed != "idle" and now_s - self._driver_s > SILENT_S:
            self.leave()
            self.engine.trouble = f"page silent {SILENT_S:g} s: plate off, arm again"
        paths = self._paths(now_s) if self.engine.is_paced else [np.empty((0, 3))]
        for path in paths:
            self._pending.append(self.engine.advance(path).astype(np.float32))
        return self._blocks() if self._pending else []

    def due_s(self, now_s: float) -> float:
        """Return how long to wait: what a device sends is asked for twice in a block."""
        return 0.5 / BLOCKS_HZ

    def _paths(self, now_s: float) -> list[np.ndarray]:
        """Return the finger's path to now on a simulated bench, block by block."""
        rate, ticks = self.engine.rate_hz, self.block_ticks
        if math.isnan(self._begun_s):
            self._begun_s, self._asked = now_s, 0
        block_s = ticks / rate
        behind_s = self._behind_s(now_s, self._asked, BLOCKS[self.engine.source] * block_s, block_s)
        if now_s - self._heard_s > GONE_S:
            self._down = False
        return [self._next(ticks) for _ in range(int(behind_s * rate / ticks + 1e-9))]

    def _next(self, ticks: int) -> np.ndarray:
        rate = self.engine.rate_hz
        self._asked += ticks
        wanted = self._wanted(self._begun_s + self._asked / rate, ticks / rate)
        if wanted is not None:
            wanted = wanted._replace(x_mm=min(max(wanted.x_mm, -self._reach_mm), self._reach_mm))
        return self.finger.block(wanted, ticks, rate)

    def _blocks(self) -> list[Block]:
        rows = np.concatenate(self._pending, axis=1)
        whole = rows.shape[1] // self.block_ticks * self.block_ticks
        self._pending = [rows[:, whole:]]
        return [self._keep(rows[:, at : at + self.block_ticks]) for at in range(0, whole, self.block_ticks)]
