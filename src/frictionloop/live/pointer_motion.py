"""Where a live finger is: from pointer events that come now and then to a place, a speed and a load at every tick."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

LATE_S = 1.0 / 60.0
"""The finger follows one pointer sample late, so that its place lies between two that are known (60 Hz)."""
KEPT = 256
"""Pointer samples that are remembered: four seconds at 60 Hz."""
OFFSETS = 128
"""Messages that tell how the page's clock stands to ours: two seconds at 60 Hz."""
FASTEST_MM_S = 400.0
"""Fastest stroke, within what the position sensor of a bench follows (assumed)."""
LANDING_N_S = 25.0
"""Fastest change of the load: 0.5 N in 20 ms (assumed)."""


class Sample(NamedTuple):
    """A pointer at one time."""

    time_s: float
    x_mm: float
    y_mm: float
    load_n: float


class PointerPath:
    """Pointer samples of a page, in the time of the session.

    The page's clock is not ours: the least time from an event to its arrival, of the last `OFFSETS` messages, is taken
    for the offset of the clocks.
    """

    def __init__(self) -> None:
        self._samples: deque[tuple[Sample, float]] = deque(maxlen=KEPT)  # each with its page time, ms
        self._offsets_s: deque[float] = deque(maxlen=OFFSETS)
        self.reached_ms = math.nan
        """Page time of the newest event that the finger has reached, ms."""

    def heard_s(self, arrived_s: float, page_ms: float) -> float:
        """Return when a page said what arrives now, in our time: earlier, where it or the network was stopped."""
        self._offsets_s.append(arrived_s - 1e-3 * page_ms)
        return 1e-3 * page_ms + min(self._offsets_s)

    def add(self, events: np.ndarray) -> None:
        """Take events, rows of page time (ms), x (mm), y (mm) and load (N), of a page that was heard."""
        offset_s = min(self._offsets_s)
        for page_ms, *row in events.tolist():
            time_s = 1e-3 * page_ms + offset_s
            if not self._samples or time_s > self._samples[-1][0].time_s:
                self._samples.append((Sample(time_s, *row), page_ms))

    def clear(self) -> None:
        """Forget what came before."""
        self._samples.clear()

    def next_s(self, after_s: float) -> float:
        """Return when the finger reaches the next sample after a time; infinity if it knows of none."""
        found = math.inf
        for sample, _ in reversed(self._samples):
            if sample.time_s + LATE_S <= after_s:
                break
            found = sample.time_s + LATE_S
        return found

    def at(self, time_s: float) -> Sample | None:
        """Return the pointer at a time, linear between two samples one sample late; None before the first."""
        wanted, after = time_s - LATE_S, None
        for sample, page_ms in reversed(self._samples):
            if sample.time_s <= wanted:
                self.reached_ms = page_ms
                if after is None:
                    return sample
                share = (wanted - sample.time_s) / (after.time_s - sample.time_s)
                mixed = (a + share * (b - a) for a, b in zip(sample[1:], after[1:], strict=True))
                return Sample(wanted, *mixed)
            after = sample
        return after


class Ghost:
    """A finger that strokes by itself: back and forth at one speed, with smooth turns.

    x(t) is a triangle wave whose corners are rounded over 0.1 s.
    """

    TURN_S = 0.1

    def __init__(self, speed_mm_s: float = 40.0, stroke_mm: float = 80.0) -> None:
        self.speed_mm_s, self.stroke_mm, self._x_mm, self._v_mm_s, self._way = speed_mm_s, stroke_mm, 0.0, 0.0, 1.0

    def move(self, dt_s: float) -> float:
        """Go on for a time and return the place in mm."""
        half = self.stroke_mm / 2
        if self._way * self._x_mm >= half - abs(self._v_mm_s) * self.TURN_S / 2:
            self._way = -self._way
        step = 2.0 * self.speed_mm_s * dt_s / self.TURN_S
        self._v_mm_s += min(max(self._way * self.speed_mm_s - self._v_mm_s, -step), step)
        self._x_mm += self._v_mm_s * dt_s
        return self._x_mm


class LiveFinger:
    """The finger on the plate: it follows what it is told no faster than a finger can."""

    def __init__(self) -> None:
        self.x_mm, self.y_mm, self.speed_mm_s, self.load_n = 0.0, 0.0, 0.0, 0.0

    def block(self, wanted: Sample | None, ticks: int, rate_hz: float) -> np.ndarray:
        """Return the path of a block, rows of place (m), speed (m/s) and load (N); None lifts the finger."""
        span_s = ticks / rate_hz
        press = 0.0 if wanted is None else wanted.load_n
        if wanted is not None and self.load_n == 0.0:  # in the air it goes where it lands
            self.x_mm, self.y_mm = wanted.x_mm, wanted.y_mm
        way = 0.0 if wanted is None else wanted.x_mm - self.x_mm
        way = min(max(way, -FASTEST_MM_S * span_s), FASTEST_MM_S * span_s)
        more = min(max(press - self.load_n, -LANDING_N_S * span_s), LANDING_N_S * span_s)
        share = np.arange(1, ticks + 1) / ticks
        path = np.empty((ticks, 3))
        path[:, 0], path[:, 1] = 1e-3 * (self.x_mm + way * share), 1e-3 * way / span_s
        path[:, 2] = np.maximum(self.load_n + more * share, 0.0)
        self.x_mm, self.speed_mm_s = self.x_mm + way, way / span_s
        self.load_n = float(path[-1, 2])
        return path
