"""Many runs at once, keeping metrics instead of traces: tiles of lanes, shared out by joblib."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import joblib
import numpy as np
import xarray as xr

from frictionloop.loop.kept import Result, resumed
from frictionloop.loop.lowering import lower
from frictionloop.loop.metrics import DEFAULT_METRICS, METRICS, Sums
from frictionloop.loop.points import Points, fingerprint, points_of
from frictionloop.loop.progress import progress_bar
from frictionloop.loop.record import provenance
from frictionloop.loop.simulate import run_tile
from frictionloop.loop.slab import LANES
from frictionloop.loop.structure import COUPLED, STRUCTURAL, structure
from frictionloop.loop.timing import periods_in
from frictionloop.parameters import Recording, System
from frictionloop.physics.sources import sampler
from frictionloop.quantities import FrictionloopError

SAVE_EVERY = 1_000_000_000
"""Control periods, over all lanes, between two savings of what is done: a few seconds of work."""


class SweepInterrupted(KeyboardInterrupt):
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
    progress: bool | None = None,
) -> xr.Dataset:
    """Simulate many variations of a system and return metrics over them.

    Parameters
    ----------
    system : System
        The base system.
    points : mapping or sequence of mappings
        ``{"controller.kp": kps, "controller.ki": kis}`` for their grid (one dim per path), or a list of overrides
        ``[{...}, {...}]`` (dim ``point``).
    duration_s : float
        Duration of each run in s.
    seeds : int or sequence of int
        Number of noise seeds (0, 1, ...) or the seeds themselves; the last dim, ``seed``.
    metrics : sequence of str, optional
        Names from ``fl.METRICS``; by default r2_identity, rms_error and saturation_index.
    score_from_s : float
        Start of the scored part of each run in s.
    n_jobs : int, optional
        Parallel workers, by default one per core. Threads, unless a joblib back end is active: inside
        ``joblib.parallel_config(backend="dask")`` the same call runs on a Dask cluster.
    path : path, optional
        HDF5 file that keeps what is done, also on Ctrl-C.
    resume : bool
        Continue the sweep in ``path`` instead of starting over.
    progress : bool, optional
        Show a progress bar; by default on a terminal.

    Returns
    -------
    xarray.Dataset
        One variable per metric. Results do not depend on the number of workers, nor on which points run together.

    Raises
    ------
    FrictionloopError
        For an unknown path, metric or value, naming it; nothing has run then.
    SweepInterrupted
        On Ctrl-C, carrying the partial result.

    """
    names = tuple(DEFAULT_METRICS if metrics is None else metrics)
    unknown = [name for name in names if name not in METRICS]
    if unknown or not names:
        raise FrictionloopError(f"metrics = {list(names)!r}: accepted are {', '.join(METRICS)}")
    grid = points_of(points, seeds)
    structures = _structures(system, grid, duration_s, score_from_s)
    key = fingerprint(system, grid, duration_s, score_from_s, names)
    values = resumed(path, key, names, grid) if resume else np.full((len(names), int(np.prod(grid.shape))), np.nan)
    result = Result(values, names, grid, provenance(system, duration_s=duration_s, fingerprint=key), path)
    result.keep()
    tiles = list(_tiles(structures, np.isnan(values).all(axis=0), len(grid.seeds)))
    job, of = joblib.delayed(_run), list(grid.lanes())
    calls = (job(system, tile, [of[lane] for lane in tile], duration_s, score_from_s, names) for tile in tiles)
    workers = joblib.Parallel(n_jobs=n_jobs or _cores(), prefer="threads", return_as="generator_unordered")
    with progress_bar("sweep", len(tiles), progress) as advance:
        try:
            unsaved = 0.0
            for lanes, numbers in workers(calls):
                values[:, lanes] = numbers
                advance()
                unsaved += len(lanes) * duration_s * system.controller.rate_hz
                if unsaved > SAVE_EVERY:
                    result.keep()
                    unsaved = 0.0
        except KeyboardInterrupt:
            raise SweepInterrupted(result.dataset()) from None
        finally:
            result.keep()
    return result.dataset()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _structures(system: System, grid: Points, duration_s: float, score_from_s: float) -> list[object]:
    """Try every value of a sweep before anything runs and return the structure of each point."""
    read: set[tuple[Recording, float]] = set()

    def tried(override: dict[str, Any]) -> object:
        changed = system.evolve(override)
        periods = periods_in(changed, duration_s)
        if not (0 <= score_from_s < duration_s and round(score_from_s * changed.controller.rate_hz) < periods):
            raise FrictionloopError(
                f"score_from_s = {score_from_s!r} s: must be at least 0 and below duration_s = {duration_s!r} s"
            )
        for source in (changed.setpoint, changed.disturbance):
            # A file that is missing or too short is found now, not when its tile runs.
            rate = changed.controller.rate_hz
            if isinstance(source, Recording) and (source, rate) not in read:
                read.add((source, rate))
                sampled = sampler(source, rate, 0, 0)
                assert sampled is not None
                sampled(0, periods)
        return structure(changed)

    # Systems are not kept: thousands of small objects would cost the garbage collector more than the kernel takes.
    probed = [tried(override) for override in grid.probes()]
    if not grid.gridded:
        return probed
    plain = all(not path.endswith(STRUCTURAL) and axis.dtype.kind in "if" for path, axis in grid.axes.items())
    plain = plain and sum(path.endswith(COUPLED) for path in grid.axes) < 2
    return probed[:1] * len(grid.overrides) if plain else [tried(override) for override in grid.overrides]


def _tiles(structures: Sequence[object], wanted: np.ndarray, seeds: int) -> Iterator[list[int]]:
    """Yield the lane numbers of each tile: lanes of one structure, single lanes if few are left."""
    groups: dict[object, list[int]] = {}
    for lane in np.flatnonzero(wanted).tolist():
        groups.setdefault(structures[lane // seeds], []).append(lane)
    for lanes in groups.values():
        for start in range(0, len(lanes), LANES):
            part = lanes[start : start + LANES]
            # Up to two lanes cost less one by one than as a padded tile; the bits are the same.
            yield from [part] if len(part) > 2 else [[lane] for lane in part]


def _run(
    system: System,
    lanes: list[int],
    points: list[tuple[dict[str, Any], int]],
    duration_s: float,
    score_from_s: float,
    names: tuple[str, ...],
) -> tuple[list[int], np.ndarray]:
    """Run one tile; module-level and made of plain values, so that any joblib back end can ship it."""
    groups = 0
    for name in names:
        groups |= METRICS[name].groups
    systems = [system.evolve(override) for override, _ in points]
    periods = periods_in(systems[0], duration_s)
    score_from = round(score_from_s * systems[0].controller.rate_hz)
    tile = lower(systems, [seed for _, seed in points], groups=groups, score_from=score_from)
    run_tile(tile, periods)
    sums = Sums._make([*tile.slab.view("sums")[: len(Sums._fields) - 1, : len(lanes)], periods - score_from])
    return lanes, np.array([METRICS[name].of(sums) for name in names])
