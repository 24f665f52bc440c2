"""Telemetry into rows: which sample is which, what is missing, and nothing that cannot be."""

from __future__ import annotations

import numpy as np

from frictionloop.device.codec import Message
from frictionloop.quantities.schema import schema

CHANNELS = tuple(channel["name"] for channel in schema()["channel"])
SCALES = np.array([float(channel["scale"]) for channel in schema()["channel"]])
ALL = (1 << len(CHANNELS)) - 1
"""Mask of all channels."""
FLAGS = CHANNELS.index("flags")
TICK_HZ: int = schema()["protocol"]["tick_hz"]
SLACK_US = 2_000_000
"""Frames wait for the line at most so long on the device (assumed; its ring holds some ms)."""

DOUBTED = 8
"""After so many frames in a row that do not follow from the last good one, that one is no longer believed (assumed)."""


class Recorder:
    """Rows of a run, one per `decimation` ticks, from the first sample at which the loop is in the state asked for.

    Samples of ticks up to `since` are of an earlier run: the device's ring and the line still held them. Rows wait here
    until somebody takes them.
    """

    def __init__(self, rows: int, decimation: int, state: int) -> None:
        self.rows, self.decimation, self.state = rows, decimation, state
        self.since: int | None = None
        self.taken = 0
        """Rows that were taken."""
        self.newest: dict[str, float] = {}
        """The last sample that came, its channels in their units, and when it was, from the first row on."""
        self._raw = np.zeros((0, len(CHANNELS)), np.int16)
        self._there = np.zeros(0, bool)
        self.start_tick: int | None = None
        self.reached = 0
        """Rows up to the last one seen."""
        self.implausible = 0
        """Samples in frames that passed their CRC and cannot be: another mask, a time that does not fit."""
        self.dropped = 0
        """Samples that the device dropped, by its own count."""
        self._last: tuple[int, int, int] | None = None  # tick, stamp, dropped of the frame before
        self._doubted = 0

    def take(self, message: Message) -> None:
        """Take a telemetry message."""
        values = message["values"]
        if not self._is_plausible(message):
            self.implausible += len(values) // len(CHANNELS)
            self._doubted += 1
            if self._doubted >= DOUBTED:  # it was the one before these that cannot be
                self._last, self._doubted = None, 0
            return
        self._doubted = 0
        before = self._last
        self._last = message["tick"], message.stamp, message["dropped"]
        if before is not None and self.is_new(message["tick"]):
            self.dropped += (message["dropped"] - before[2]) % 2**16
        samples = values.reshape(-1, len(CHANNELS))
        if self.start_tick is None:
            samples = self._begin(message["tick"], samples)
        if self.start_tick is not None and len(samples):
            self._keep(message["tick"], samples)

    def is_new(self, tick: int) -> bool:
        """Whether a tick is after those of earlier runs; ticks count modulo 2^32."""
        return self.since is None or 0 < (tick - self.since) % 2**32 < 2**31

    @property
    def is_full(self) -> bool:
        """Whether the last row is there or past."""
        return self.reached >= self.rows

    def take_rows(self, until: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the channels of the rows not taken yet up to one, (rows, channels), and which were recorded."""
        count = until - self.taken
        self._grow(count)
        raw, there = self._raw[:count], self._there[:count]
        self._raw, self._there, self.taken = self._raw[count:].copy(), self._there[count:].copy(), until
        return raw, there

    def _grow(self, count: int) -> None:
        if more := max(count - len(self._raw), 0):
            self._raw = np.concatenate([self._raw, np.zeros((more, len(CHANNELS)), np.int16)])
            self._there = np.concatenate([self._there, np.zeros(more, bool)])

    def _is_plausible(self, message: Message) -> bool:
        if message["mask"] != ALL or message["decimation"] != self.decimation:
            return False
        if len(message["values"]) % len(CHANNELS) or not len(message["values"]):
            return False
        if self._last is None:
            return True
        ticks = (message["tick"] - self._last[0]) % 2**32
        if not 0 < ticks < 2**31 or ticks % self.decimation:
            return False
        late_us = (message.stamp - self._last[1] - ticks * (1_000_000 // TICK_HZ) + 2**31) % 2**32 - 2**31
        return abs(late_us) <= SLACK_US

    def _begin(self, tick: int, samples: np.ndarray) -> np.ndarray:
        new = [self.is_new(tick + k * self.decimation) for k in range(len(samples))]
        there = np.flatnonzero((state_of(samples[:, FLAGS]) == self.state) & new)
        if there.size:
            self.start_tick = (tick + int(there[0]) * self.decimation) % 2**32
        return samples

    def _keep(self, tick: int, samples: np.ndarray) -> None:
        assert self.start_tick is not None
        ticks = (tick - self.start_tick + 2**31) % 2**32 - 2**31  # negative where the frame began before the run
        first = ticks // self.decimation
        last = min(first + len(samples), self.rows)
        begin = max(first, self.taken)
        if begin < last:
            self._grow(last - self.taken)
            here = slice(begin - self.taken, last - self.taken)
            self._raw[here], self._there[here] = samples[begin - first : last - first], True
            told = zip(CHANNELS, (samples[last - first - 1] * SCALES).tolist(), strict=True)
            self.newest = {"elapsed_s": last * self.decimation / TICK_HZ, **dict(told)}
        self.reached = max(self.reached, last)


def state_of(flags: np.ndarray) -> np.ndarray:
    """Return the state in the channel `flags`."""
    return flags.astype(np.int32) >> 2 & 3


def fault_of(flags: np.ndarray) -> np.ndarray:
    """Return the fault in the channel `flags`."""
    return flags.astype(np.int32) >> 4 & 15
