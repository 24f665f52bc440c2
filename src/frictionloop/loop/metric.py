"""Metrics from outside: computed sample by sample inside the kernel, or from a whole run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.loop.kernel.slab import ROWS
from frictionloop.quantities import FrictionloopError, trees
from frictionloop.quantities.blame import place, theirs

if TYPE_CHECKING:
    from frictionloop.loop.kernel.lowering import Tile
    from frictionloop.parameters import System


class Sample(NamedTuple):
    """What a streaming metric is given of a control period: forces in N, amplitude in um, SI units for the motion."""

    f_r: float
    f_a: float
    f_m: float
    u: float
    a: float
    d: float
    saturated: float
    position: float
    speed: float
    load: float


@dataclass(frozen=True)
class StreamingMetric:
    """A number per run that needs no traces: ``step(state, sample, dt) -> state`` at each scored control period."""

    name: str
    step: Any
    """Compiled with ``fl.step``."""
    state: type
    """Named tuple of numbers, all zero before the first period."""
    of: Callable[[Any, Any], Any]
    """(state with an array over runs for each number, number of scored periods) -> value of each run."""
    units: str = "1"
    long_name: str = ""
    groups: int = 0


@dataclass(frozen=True)
class RunMetric:
    """A number computed from the traces of a run: ``of(run) -> float``. Each point of a sweep then runs alone."""

    name: str
    of: Callable[[xr.Dataset], float]
    units: str = "1"
    long_name: str = ""
    groups: int = 0


def first_rows(metrics: Sequence[StreamingMetric]) -> list[int]:
    """Return the row at which the state of each metric begins, and the row after the last."""
    sizes = [trees.size(each.state) for each in metrics]
    return [ROWS + sum(sizes[:i]) for i in range(len(sizes) + 1)]


def streamed(tile: Tile, metrics: Sequence[StreamingMetric], count: Any) -> dict[str, Any]:
    """Return the value of each streaming metric over the lanes of a tile that has run."""
    lanes, found = np.size(count), {}
    for metric, first in zip(metrics, first_rows(metrics), strict=False):
        rows = tile.slab.rows(range(first, first + trees.size(metric.state)))[:, :lanes]
        try:
            values = metric.of(trees.shaped(metric.state, list(rows)), count)
            found[metric.name] = np.broadcast_to(np.asarray(values, float), lanes)
        except Exception as error:
            raise theirs(f'metric "{metric.name}"', metric.of, error) from error
    return found


def values_of_runs(
    metrics: Mapping[str, RunMetric], systems: Sequence[System], seeds: Sequence[int], duration_s: float, from_s: float
) -> dict[str, list[float]]:
    """Return the value of each metric of each run; the run is told from ``from_s`` on."""
    from frictionloop.loop.simulate import simulate

    found: dict[str, list[float]] = {name: [] for name in metrics}
    if not metrics:
        return {}
    for system, seed in zip(systems, seeds, strict=False):
        run = simulate(system, duration_s, seed)
        scored = run.isel(time=slice(round(from_s * system.controller.rate_hz), None))
        for name, metric in metrics.items():
            try:
                value = np.asarray(metric.of(scored), float)
            except Exception as error:
                raise theirs(f'metric "{name}"', metric.of, error) from error
            if value.size != 1:
                where, shape = place(metric.of), value.shape
                raise FrictionloopError(f'metric "{name}": {where}: returned shape {shape}; must be one number per run')
            found[name].append(float(value.ravel()[0]))
    return found
