"""A run on its way from telemetry into its file, second by second, in the form of `simulate`; which samples count."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.device.codec import Message
from frictionloop.device.link import Link
from frictionloop.loop.growing_file import Column, DiskFull, Spool
from frictionloop.loop.record import VARIABLES, load, provenance
from frictionloop.parameters import SCHEMA, System
from frictionloop.parameters.motion import Strokes
from frictionloop.physics.motion import scored_edge_m
from frictionloop.quantities.code_version import package_version
from frictionloop.quantities.protocol_schema import schema

LOAD_SHARE = 0.5
"""Share of the mean load below which nothing counts (parameters/motion, `unscored_n`)."""


def counted(sliding: np.ndarray, position_m: np.ndarray, load_n: np.ndarray, system: System | None) -> np.ndarray:
    """Return the samples that count: |x| <= `scored_edge_m`, N >= load_n / 2, while the finger slides.

    The rule of `simulate` (kernel/motion_tile), with the measured position and load for the true ones. A finger at the
    bench may rest where a simulated one never does, so that its reading must be valid besides. Without strokes in the
    System, or without a System, that is all.

    Parameters
    ----------
    sliding : array (time,) of bool
        Samples that arrived and whose reading was valid.
    position_m, load_n : array (time,)
        As measured; NaN where a sample was lost.
    system : System, optional
        What the device was set up from.
    """
    if system is None or not isinstance(system.motion, Strokes):
        return sliding.copy()
    edge_m = scored_edge_m(system.motion, system.finger)
    return sliding & (np.abs(position_m) <= edge_m) & (load_n >= LOAD_SHARE * system.motion.load_n)


def away_from_turns(position_m: np.ndarray, speed_m_s: np.ndarray, way_m: float) -> np.ndarray:
    """Return which samples are so far or farther from the turn before them and from the one after.

    Parameters
    ----------
    position_m, speed_m_s : array
        Measured position and speed, (samples,); NaN where a sample was lost.
    way_m : float
        Distance in m.

    Returns
    -------
    array of bool
        (samples,); a run without a turn is away from all of them.
    """
    position_m = np.asarray(position_m)
    going = np.sign(np.nan_to_num(np.asarray(speed_m_s)))
    samples = np.arange(going.size)
    moving = np.flatnonzero(going)
    if moving.size == 0:
        return np.ones(going.size, bool)
    # While it rests, or is not heard of, a finger goes where it went last.
    last = np.maximum.accumulate(np.where(going != 0, samples, moving[0]))
    turns = np.flatnonzero(np.diff(going[last]) != 0) + 1
    places = np.concatenate([[np.nan], position_m[turns], [np.nan]])  # nobody knows of turns before and after the run
    after = np.searchsorted(turns, samples, side="right")
    with np.errstate(invalid="ignore"):
        near = (np.abs(position_m - places[after]) < way_m) | (np.abs(position_m - places[after + 1]) < way_m)
    return ~near


CHANNELS = tuple(channel["name"] for channel in schema()["channel"])
SCALES = np.array([float(channel["scale"]) for channel in schema()["channel"]])
ALL = (1 << len(CHANNELS)) - 1
"""Mask of all channels."""
FLAGS = CHANNELS.index("flags")
SLACK_US = 2_000_000
"""Frames wait for the line at most so long on the device (assumed; its ring holds some ms)."""

DOUBTED = 8
"""After so many frames in a row that do not follow from the last good one, that one is no longer believed (assumed)."""


class Recorder:
    """Rows of a run, one per `decimation` ticks, from the first sample at which the loop is in the state asked for.

    Samples of ticks up to `since` are of an earlier run: the device's ring and the line still held them. Rows wait here
    until somebody takes them.
    """

    def __init__(self, rows: int, decimation: int, state: int, tick_hz: int) -> None:
        self.rows, self.decimation, self.state, self.tick_hz = rows, decimation, state, tick_hz
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
        late_us = (message.stamp - self._last[1] - ticks * (1_000_000 // self.tick_hz) + 2**31) % 2**32 - 2**31
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
            self.newest = {"elapsed_s": last * self.decimation / self.tick_hz, **dict(told)}
        self.reached = max(self.reached, last)


def state_of(flags: np.ndarray) -> np.ndarray:
    """Return the state in the channel `flags`."""
    return flags.astype(np.int32) >> 2 & 3


def fault_of(flags: np.ndarray) -> np.ndarray:
    """Return the fault in the channel `flags`."""
    return flags.astype(np.int32) >> 4 & 15


TOLD = {"a": ("um", "amplitude command, zero-to-peak")}
"""What a device tells where a simulated run has what the plate does."""
BOOLS = ("saturated", "sliding", "scored")
SPOOL_S = 1.0
"""So often what was recorded goes into the file: no more is lost when the process is killed."""
COUNTS = ("lost_samples", "gaps", "dropped_samples", "implausible_samples", "start_tick")


class Recording:
    """The file of a run while it is recorded; what is missing is NaN, not ``scored``, and counted."""

    def __init__(
        self, path: str | os.PathLike[str], recorder: Recorder, link: Link, system: System | None, attrs: dict[str, Any]
    ) -> None:
        self._recorder, self._link, self._system = recorder, link, system
        self._lost = self._gaps = 0
        self._ends_there = True
        self._every = max(round(SPOOL_S * recorder.tick_hz / recorder.decimation), 1)
        # A bench that is simulated knows the force on the finger; a device's line knows none.
        self._felt = link.pipe.felt(0, 0, 1) is not None
        names = [name for name in CHANNELS if CHANNELS.index(name) != FLAGS] + ["f_a"] * self._felt
        columns = {name: _column(name, "f8") for name in names} | {name: _column(name, "bool") for name in BOOLS}
        kept = provenance(system, source=link.pipe.source) if system else _without_system(link.pipe.source)
        self.spool = Spool(path, columns, recorder.decimation / recorder.tick_hz, kept | attrs, COUNTS)

    @property
    def recorded(self) -> int:
        """Samples in the file that were recorded."""
        return self.spool.rows - self._lost

    def keep(self) -> None:
        """Append what has come, if it is a second's worth; raises DiskFull."""
        if self._recorder.reached - self._recorder.taken >= self._every:
            self._append(self._recorder.reached)

    def finish(self, rows: int, attrs: dict[str, Any], path: str | os.PathLike[str] | None) -> xr.Dataset:
        """Append what is left up to some rows in all, and return what the file holds; without a path it goes then."""
        try:
            while self._recorder.taken < rows and not self.spool.is_full:
                self._append(min(self._recorder.taken + self._every, rows))
        except DiskFull as full:
            attrs = attrs | {"ended": str(full)}
        self.spool.path = Path(path or self.spool.partial)
        run = load(self.spool.finish(attrs | self._counts()))
        if path is None:
            run.load().close()
            self.spool.partial.unlink()
        return run

    def _append(self, until: int) -> None:
        recorder, first = self._recorder, self._recorder.taken
        raw, there = recorder.take_rows(until)
        self._lost += int(np.count_nonzero(~there))
        self._gaps += int(np.count_nonzero(np.diff(np.concatenate([[self._ends_there], there]).astype(np.int8)) < 0))
        self._ends_there = bool(there[-1])
        self.spool.append(self._columns(raw, there, first), self._counts())

    def _columns(self, raw: np.ndarray, there: np.ndarray, first: int) -> dict[str, np.ndarray]:
        recorder = self._recorder
        forces = np.where(there[:, None], raw * SCALES, np.nan)
        data = {name: forces[:, i] for i, name in enumerate(CHANNELS) if i != FLAGS}
        if self._felt:
            tick = 0 if recorder.start_tick is None else recorder.start_tick + first * recorder.decimation
            felt = self._link.pipe.felt(tick, len(there), recorder.decimation)
            data["f_a"] = np.full(len(there), np.nan) if felt is None or recorder.start_tick is None else felt
        data["saturated"] = there & (raw[:, FLAGS] & 2 != 0)
        data["sliding"] = there & (raw[:, FLAGS] & 1 != 0)
        data["scored"] = counted(data["sliding"], data["position"], data["load"], self._system)
        return data

    def _counts(self) -> dict[str, int]:
        recorder = self._recorder
        start = -1 if recorder.start_tick is None else recorder.start_tick
        found = self._lost, self._gaps, recorder.dropped, recorder.implausible, start
        return dict(zip(COUNTS, found, strict=True))


def _column(name: str, dtype: str) -> Column:
    units, meaning = TOLD.get(name) or VARIABLES[name]
    return Column(dtype, {"units": units, "long_name": meaning})


def _without_system(source: str) -> dict[str, Any]:
    """Return the attributes of a device that was set up by hand: nobody knows which System that is."""
    return {"version": package_version(), "schema": SCHEMA, "source": source}
