"""What presents strokes: the simulated bench here, a device in `device_engine`, one interface for both."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import NamedTuple, Protocol

import xarray as xr

from frictionloop.experiments.measured_finger import MeasuredFinger, simulated_finger
from frictionloop.experiments.respondent import Live, Presented, Respondent, Response
from frictionloop.experiments.timeline import Timeline
from frictionloop.experiments.trials import force_of
from frictionloop.loop.kernel.placing import tiles_of
from frictionloop.loop.kernel.structure import structure
from frictionloop.loop.parallel_runs import shared_out, worker_count
from frictionloop.loop.simulate import traced
from frictionloop.parameters import System

SHOWN_S = 0.03
"""How often a stroke that goes on is shown (assumed: 30 times a second)."""


class Stroke(NamedTuple):
    """One stroke to present: the system with its effect and its motion, how long, and the seed of all noise."""

    system: System
    duration_s: float
    seed: int


class Engine(Protocol):
    """What presents strokes and tells the time."""

    source: str
    """simulated, or device."""

    def present(self, strokes: Sequence[Stroke], timeline: Timeline, shown: Respondent) -> list[Presented]:
        """Present the strokes of a trial one after the other, with cue and gaps, and return what was recorded."""
        ...

    def answered(self, response: Response, presented: Sequence[Presented]) -> tuple[Response, float]:
        """Return an answer with its time on the device clock, and by how much clocks have jumped meanwhile, s."""
        ...

    def reach(self, system: System, seed: int) -> MeasuredFinger:
        """Return what the finger can be given, by plain strokes."""
        ...

    def close(self) -> None:
        """Let go of the device."""
        ...


class BenchEngine:
    """The simulated bench: a clock that is counted."""

    source = "simulated"

    def __init__(self, time_s: float = 0.0) -> None:
        self.time_s = time_s

    def present(self, strokes: Sequence[Stroke], timeline: Timeline, shown: Respondent) -> list[Presented]:
        """Simulate the strokes of a trial; for a person in the time that a device takes."""
        runs = simulated(strokes, 1)
        for interval, (run, stroke) in enumerate(zip(runs, strokes, strict=True), 1):
            if shown.paced:
                time.sleep(timeline.cue_s if interval == 1 else timeline.gap_s)
            shown.cued(interval, stroke.duration_s)
            if shown.paced:
                _show(run, interval, stroke.duration_s, shown)
            shown.stroked(interval, run)
        return self.timed(runs, strokes, timeline)

    def timed(self, runs: Sequence[xr.Dataset], strokes: Sequence[Stroke], timeline: Timeline) -> list[Presented]:
        """Return the runs of a trial's strokes with their times, and count on."""
        found: list[Presented] = []
        for run, stroke in zip(runs, strokes, strict=True):
            onset = self.time_s + (timeline.gap_s if found else timeline.cue_s)
            self.time_s = onset + stroke.duration_s
            found.append(Presented(run, onset, self.time_s))
        return found

    def answered(self, response: Response, presented: Sequence[Presented]) -> tuple[Response, float]:
        """Count on."""
        self.time_s += max(response.rt_s, 0.0)
        return response, 0.0

    def reach(self, system: System, seed: int) -> MeasuredFinger:
        """Return that of the simulated finger."""
        return simulated_finger(system, seed)

    def close(self) -> None:
        """Do nothing: there is nothing to let go of."""


def _show(run: xr.Dataset, interval: int, duration_s: float, shown: Respondent) -> None:
    """Show a run as it would come from a device."""
    start = time.monotonic()
    force = run[force_of(run)].values
    while (elapsed := time.monotonic() - start) < duration_s:
        k = min(int(elapsed / duration_s * force.size), force.size - 1)
        setpoint, speed, load = (float(run[name].values[k]) for name in ("f_r", "speed", "load"))
        shown.live(Live(interval, elapsed, float(force[k]), setpoint, 1e3 * speed, load))
        time.sleep(SHOWN_S)


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
