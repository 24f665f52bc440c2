"""What presents strokes: the simulated bench here, a device in `device_engine`, one interface for both."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import xarray as xr

from frictionloop.experiments.timeline import Timeline
from frictionloop.loop.kernel.placing import tiles_of
from frictionloop.loop.kernel.structure import structure
from frictionloop.loop.simulate import traced
from frictionloop.loop.workers import shared_out, worker_count
from frictionloop.parameters import System


class Stroke(NamedTuple):
    """One stroke to present: the system with its effect and its motion, how long, and the seed of all noise."""

    system: System
    duration_s: float
    seed: int


class Presented(NamedTuple):
    """One stroke that was presented."""

    run: xr.Dataset
    """As of `simulate`."""
    onset_s: float
    """Its start on the device clock."""
    offset_s: float
    """Its end on the device clock."""
    uncertainty_s: float = 0.0
    """Standard deviation of a time of the host on the device clock."""


class Engine(Protocol):
    """What presents strokes and tells the time."""

    source: str
    """simulated, or device."""

    def present(self, strokes: Sequence[Stroke], timeline: Timeline) -> list[Presented]:
        """Present the strokes of a trial one after the other, with cue and gaps, and return what was recorded."""
        ...

    def answered(self, rt_s: float) -> None:
        """Hear that an answer came so long after the last stroke."""
        ...

    def close(self) -> None:
        """Let go of the device."""
        ...


class BenchEngine:
    """The simulated bench: a clock that is counted.

    Parameters
    ----------
    time_s : float
        Where the clock goes on.
    """

    source = "simulated"

    def __init__(self, time_s: float = 0.0) -> None:
        self.time_s = time_s

    def present(self, strokes: Sequence[Stroke], timeline: Timeline) -> list[Presented]:
        """Simulate the strokes of a trial."""
        return self.timed(simulated(strokes, 1), strokes, timeline)

    def timed(self, runs: Sequence[xr.Dataset], strokes: Sequence[Stroke], timeline: Timeline) -> list[Presented]:
        """Return the runs of a trial's strokes with their times, and count on."""
        found: list[Presented] = []
        for run, stroke in zip(runs, strokes, strict=True):
            onset = self.time_s + (timeline.gap_s if found else timeline.cue_s)
            self.time_s = onset + stroke.duration_s
            found.append(Presented(run, onset, self.time_s))
        return found

    def answered(self, rt_s: float) -> None:
        """Count on."""
        self.time_s += max(rt_s, 0.0)

    def close(self) -> None:
        """Do nothing: there is nothing to let go of."""


def simulated(strokes: Sequence[Stroke], n_jobs: int | None = None) -> list[xr.Dataset]:
    """Return the runs of strokes: those of one structure and duration as lanes of a tile, tiles over threads."""
    keys = [(structure(each.system), each.duration_s) for each in strokes]
    tiles = list(tiles_of(keys, range(len(strokes))))
    found: dict[int, xr.Dataset] = {}
    workers = min(worker_count(n_jobs), len(tiles))
    for lanes, runs in shared_out(_tile, (([(k, strokes[k]) for k in lanes],) for lanes in tiles), workers):
        found |= dict(zip(lanes, runs, strict=True))
    return [found[k] for k in range(len(strokes))]


def _tile(strokes: list[tuple[int, Stroke]]) -> tuple[list[int], list[xr.Dataset]]:
    lanes, some = [k for k, _ in strokes], [stroke for _, stroke in strokes]
    return lanes, list(traced([each.system for each in some], [each.seed for each in some], some[0].duration_s))
