"""Many runs at once, keeping metrics instead of traces: tiles of lanes, shared out over workers."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.input_findings import warn_of_signals
from frictionloop.loop.kernel.lane_grouping import placed, tiles_of
from frictionloop.loop.kernel.loop import Tile
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.metric import AgainMetric, Metric, RunMetric, StreamingMetric
from frictionloop.loop.metrics import DEFAULT_METRICS, METRICS
from frictionloop.loop.parallel_runs import shared_out, worker_count
from frictionloop.loop.progress import progress_bar
from frictionloop.loop.record import provenance
from frictionloop.loop.registered_blocks import outside_digest, register_all, registered
from frictionloop.loop.simulate import lanes_without_number, no_number, periods_in, run_tile, traced
from frictionloop.loop.sweep_checkpoint import CLOCK, Result, Timely, check_free, computing, resumed
from frictionloop.loop.sweep_points import fingerprint, points_of, structures_of
from frictionloop.loop.sweep_shards import ShardResult, points_of_shard, shard_file, shard_values
from frictionloop.parameters import System, check_system
from frictionloop.quantities import FrictionloopError, flat_tuples, must_be
from frictionloop.quantities.class_help import Brief
from frictionloop.quantities.outside_errors import place, theirs
from frictionloop.quantities.whole_files import only_writer


class SweepInterrupted(KeyboardInterrupt, metaclass=Brief):
    """Ctrl-C during a sweep; ``partial`` is the result so far, NaN where nothing has run."""

    def __init__(self, partial: xr.Dataset) -> None:
        super().__init__("sweep interrupted")
        self.partial = partial


def sweep(
    system: System,
    points: Mapping[str, Any] | Sequence[Mapping[str, Any]],
    duration_s: float = 10.0,
    seeds: int | Sequence[int] = 1,
    metrics: Sequence[str] | None = None,
    *,
    score_from_s: float = 0.0,
    n_jobs: int | None = None,
    path: str | os.PathLike[str] | None = None,
    resume: bool = False,
    force: bool = False,
    shard: tuple[int, int] | None = None,
    progress: bool | None = None,
    clock: Callable[[], float] = CLOCK,
) -> xr.Dataset:
    """Simulate many variations of a system and return metrics over them.

    Parameters
    ----------
    system : System
        The base system.
    points : mapping or sequence of mappings
        ``{"controller.kp": kps, "controller.ki": kis}`` for their grid (one dim per path), or a list of overrides
        ``[{...}, {...}]`` (dim ``point``). `fingers` may be a list or, as ``{"finger": people, ...}``, an axis.
    duration_s : float
        Duration of each run in s.
    seeds : int or sequence of int
        Number of noise seeds (0, 1, ...) or the seeds themselves; the last dim, ``seed``.
    metrics : sequence of str, optional
        Names from ``fl.METRICS``; by default r2_identity, rms_error and saturation_index. ``disturbance_left`` runs
        each point twice more, by itself.
    score_from_s : float
        Start of the scored part of each run in s.
    n_jobs : int, optional
        Parallel workers, by default one per core. Threads, unless a joblib back end is active: inside
        ``joblib.parallel_config(backend="dask")`` the same call runs on a Dask cluster.
    path : path, optional
        HDF5 file that keeps what is done, also on Ctrl-C: saved every few seconds, and written by no other meanwhile.
    resume : bool
        Continue the sweep in ``path`` instead of starting over; refused if other code computed its points.
    force : bool
        Start over in ``path`` whatever it holds.
    shard : (int, int), optional
        Part i of n, from 1 on, whose file goes into the folder ``path``; `open_sweep` reads them all. A part that is
        there is gone on with.
    progress : bool, optional
        Show a progress bar; by default on a terminal.
    clock : callable
        Seconds, by which ``path`` is saved.

    Returns
    -------
    xarray.Dataset
        One variable per metric. Results do not depend on the number of workers, nor on which points run together.

    Raises
    ------
    FrictionloopError
        For an unknown path, metric or value, naming it (nothing has run then), or a ``path`` that holds another
        sweep, or an unfinished one without ``resume``.
    SweepInterrupted
        On Ctrl-C, carrying the partial result.

    Warns
    -----
    SignalWarning
        As `simulate`, for the signals of the base system.

    """
    check_system(system)
    names, workers = _metrics(metrics), worker_count(n_jobs)
    grid = points_of(points, seeds)
    own = range(len(grid.overrides)) if shard is None else points_of_shard(shard, grid.shape[:-1])
    structures = structures_of(system, grid, own, duration_s, score_from_s, names)
    warn_of_signals(system)
    key = fingerprint(system, grid, duration_s, score_from_s, names, outside_digest())
    attrs = provenance(system, duration_s=duration_s, score_from_s=score_from_s, fingerprint=key, code=computing())
    file = None if shard is None else shard_file(path, shard)
    target = path if file is None else file
    with only_writer(target):
        values = np.full((len(names), len(own) * len(grid.seeds)), np.nan)
        if force and target is not None:
            Path(target).unlink(missing_ok=True)
        elif file is not None:
            values = shard_values(file, attrs, names, values)
        elif resume:
            values = resumed(path, key, attrs["code"], names, grid.shape)
        else:
            check_free(path, key)
        kind = Result if shard is None else partial(ShardResult, own=own, shard=shard)
        result = kind(values, names, grid, attrs, target)
        result.keep()
        wanted = np.flatnonzero(np.isnan(values).all(axis=0)).tolist()
        tiles = list(tiles_of(structures, wanted, len(grid.seeds)))
        first, how = own.start * len(grid.seeds), (duration_s, score_from_s, names)
        calls = ((registered(), system, tile, grid.runs(first + lane for lane in tile), *how) for tile in tiles)
        _fill(result, tiles, shared_out(_run, calls, workers), Timely(result.keep, clock), progress)
    return result.dataset()


def _fill(result: Result, tiles: Sequence[Any], done: Any, save: Timely, progress: bool | None) -> None:
    """Put the values of tiles into a result as they are done, and keep it."""
    with progress_bar("sweep", len(tiles), progress) as advance, closing(done):
        try:
            for lanes, numbers in done:
                result.values[:, lanes] = numbers
                result.done += len(lanes)
                advance()
                save()
        except KeyboardInterrupt:
            raise SweepInterrupted(result.dataset()) from None
        finally:
            result.keep()


def _metrics(metrics: Sequence[str] | None) -> tuple[str, ...]:
    if isinstance(metrics, str) or not isinstance(metrics, Iterable | None):
        raise must_be("metrics", metrics, "names, e.g. ['r2_identity']")
    names = tuple(DEFAULT_METRICS if metrics is None else metrics)
    if not names or any(name not in list(METRICS) for name in names):
        raise FrictionloopError(f"metrics = {list(names)!r}: accepted are {', '.join(METRICS)}")
    return names


def _run(
    outside: list[tuple[Any, ...]],
    system: System,
    lanes: list[int],
    points: list[tuple[dict[str, Any], int]],
    duration_s: float,
    score_from_s: float,
    names: tuple[str, ...],
) -> tuple[list[int], np.ndarray]:
    """Run one tile and return its lanes and their metrics.

    Module-level and made of plain values, so that any joblib back end can ship it.
    """
    register_all(outside)
    metrics = {name: METRICS[name] for name in names}
    of_runs = {name: each for name, each in metrics.items() if isinstance(each, RunMetric | AgainMetric)}
    of_tile = {name: each for name, each in metrics.items() if name not in of_runs}
    systems, seeds = placed(system, [override for override, _ in points]), [seed for _, seed in points]
    periods = periods_in(systems[0], duration_s)
    score_from = round(score_from_s * systems[0].controller.rate_hz)
    values: dict[str, Any] = {}
    if of_tile:
        tile = lower(systems, seeds, score_from=score_from, tallies=[each.tally for each in of_tile.values()])
        run_tile(tile, periods)
        for lane in lanes_without_number(tile):
            if lane < len(lanes):
                raise no_number(systems[lane], f"with {points[lane][0]}")
        values |= _values_of_tile(of_tile, tile, len(lanes))
    values |= _values_of_runs(of_runs, systems[: len(lanes)], seeds, duration_s, score_from_s)
    return lanes, np.array([np.broadcast_to(values[name], len(lanes)) for name in names])


def _values_of_tile(metrics: Mapping[str, Metric | StreamingMetric], tile: Tile, lanes: int) -> dict[str, Any]:
    """Return the value of each metric over the first lanes of a tile that has run."""
    found: dict[str, Any] = {}
    for name, metric in metrics.items():
        state, first = metric.tally.state, tile.places[metric.tally]
        counted, *numbers = tile.slab.view((first, first + flat_tuples.size(state)))[:, :lanes]
        # Where nothing is scored nothing can be said: NaN, which passes through the formulas without a warning.
        count = np.where(counted > 0, counted, np.nan)
        try:
            values = metric.of(flat_tuples.shaped(state, numbers), count)
            found[name] = np.broadcast_to(np.asarray(values, float), lanes)
        except Exception as error:
            raise theirs(f'metric "{name}"', metric.of, error) from error
    return found


def _values_of_runs(
    metrics: Mapping[str, RunMetric | AgainMetric],
    systems: Sequence[System],
    seeds: Sequence[int],
    duration_s: float,
    from_s: float,
) -> dict[str, list[float]]:
    """Return the value of each metric of each run; the run is told from ``from_s`` on."""
    found: dict[str, list[float]] = {name: [] for name in metrics}
    if not metrics:
        return {}
    for system, seed in zip(systems, seeds, strict=False):
        (run,) = traced([system], [seed], duration_s)
        first = round(from_s * system.controller.rate_hz)
        scored = run.isel(time=slice(first, None))
        for name, metric in metrics.items():
            if isinstance(metric, AgainMetric):
                mask = run["scored"].values.copy() if "scored" in run else np.ones(run.sizes["time"], bool)
                mask[:first] = False
                found[name].append(metric.of(run, mask) if mask.any() else np.nan)
                continue
            try:
                value = np.asarray(metric.of(scored), float)
            except Exception as error:
                raise theirs(f'metric "{name}"', metric.of, error) from error
            if value.size != 1:
                where, shape = place(metric.of), value.shape
                raise FrictionloopError(f'metric "{name}": {where}: shape {shape}; one number per run')
            found[name].append(float(value.ravel()[0]))
    return found
