"""A run on its way from the device into its file, second by second, in the form of `simulate`."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.device.counted import counted
from frictionloop.device.link import Link
from frictionloop.device.recorder import CHANNELS, FLAGS, SCALES, TICK_HZ, Recorder
from frictionloop.loop.growing_file import Column, DiskFull, Spool
from frictionloop.loop.record import VARIABLES, load, provenance
from frictionloop.parameters import SCHEMA, System
from frictionloop.quantities.version import package_version

CLOCK_BITS = 32
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
        self._every = max(round(SPOOL_S * TICK_HZ / recorder.decimation), 1)
        # A bench that is simulated knows the force on the finger; a device's line knows none.
        self._felt = link.pipe.felt(0, 0, 1) is not None
        names = [name for name in CHANNELS if CHANNELS.index(name) != FLAGS] + ["f_a"] * self._felt
        columns = {name: _column(name, "f8") for name in names} | {name: _column(name, "bool") for name in BOOLS}
        kept = provenance(system, source=link.pipe.source) if system else _without_system(link.pipe.source)
        self.spool = Spool(path, columns, recorder.decimation / TICK_HZ, kept | attrs, COUNTS)

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


def clock_fit(pairs: list[tuple[int, float, float]]) -> dict[str, float]:
    """Return how the device's clock goes against the host's, from (device's us, host's s, round trip in s).

    device_s = clock_offset_s + clock_rate host_s, host_s from the first pair on, by least squares over the half of the
    pairs with the shortest round trips: what is late was held up on one way, and does not tell the time.
    """
    if len(pairs) < 4:
        return {"clock_rate": math.nan, "clock_offset_s": math.nan, "clock_residual_s": math.nan}
    device = np.unwrap([float(pair[0]) for pair in pairs], period=2.0**CLOCK_BITS) * 1e-6
    host, trip = np.array([pair[1:] for pair in pairs]).T
    host = host - host[0]
    best = np.argsort(trip, kind="stable")[: max(len(pairs) // 2, 2)]
    offset, rate = np.polynomial.Polynomial.fit(host[best], device[best], 1).convert().coef
    residual = device[best] - offset - rate * host[best]
    fit = {"clock_rate": rate, "clock_offset_s": offset, "clock_residual_s": np.sqrt(np.mean(residual**2))}
    return {name: float(value) for name, value in fit.items()}


def _column(name: str, dtype: str) -> Column:
    units, meaning = TOLD.get(name) or VARIABLES[name]
    return Column(dtype, {"units": units, "long_name": meaning})


def _without_system(source: str) -> dict[str, Any]:
    """Return the attributes of a device that was set up by hand: nobody knows which System that is."""
    return {"version": package_version(), "schema": SCHEMA, "source": source}
