"""The values of metrics, over the lanes of a tile or run by run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from frictionloop.loop.kernel.loop import Tile
from frictionloop.loop.metric import Metric, RunMetric, StreamingMetric
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError, trees
from frictionloop.quantities.blame import place, theirs


def values_of_tile(metrics: Mapping[str, Metric | StreamingMetric], tile: Tile, lanes: int) -> dict[str, Any]:
    """Return the value of each metric over the first lanes of a tile that has run."""
    found: dict[str, Any] = {}
    for name, metric in metrics.items():
        state, first = metric.tally.state, tile.places[metric.tally]
        counted, *numbers = tile.slab.view(range(first, first + 1 + trees.size(state)))[:, :lanes]
        # Where nothing is scored nothing can be said: NaN, which passes through the formulas without a warning.
        count = np.where(counted > 0, counted, np.nan)
        try:
            values = metric.of(trees.shaped(state, numbers), count)
            found[name] = np.broadcast_to(np.asarray(values, float), lanes)
        except Exception as error:
            raise theirs(f'metric "{name}"', metric.of, error) from error
    return found


def values_of_runs(
    metrics: Mapping[str, RunMetric], systems: Sequence[System], seeds: Sequence[int], duration_s: float, from_s: float
) -> dict[str, list[float]]:
    """Return the value of each metric of each run; the run is told from ``from_s`` on."""
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
