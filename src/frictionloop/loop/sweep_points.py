"""The points of a sweep: a grid over dotted paths or a list of overrides, times seeds; tried before anything runs."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.kernel.structure import COUPLED, STRUCTURAL, structure
from frictionloop.loop.metrics import METRICS
from frictionloop.loop.simulate import check_seed, is_finite, periods_in
from frictionloop.loop.transients import STEP_TIMES
from frictionloop.parameters import Recording, System
from frictionloop.physics.sources import sampler
from frictionloop.quantities import FrictionloopError, must_be, unit_of


@dataclass(frozen=True)
class Points:
    """Every override of a sweep in order, and the axes they lie on."""

    axes: dict[str, np.ndarray]
    overrides: tuple[dict[str, Any], ...]
    seeds: tuple[int, ...]
    gridded: bool

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes, seeds last."""
        return (*(len(axis) for axis in self.axes.values()), len(self.seeds))

    def lanes(self) -> Iterator[tuple[dict[str, Any], int]]:
        """Yield (override, seed) in the order of the flattened result."""
        return itertools.product(self.overrides, self.seeds)

    def probes(self) -> Iterator[dict[str, Any]]:
        """Yield overrides that try every value once: those of a list, and each axis of a grid by itself."""
        if not self.gridded:
            yield from self.overrides
            return
        for path, axis in self.axes.items():
            for value in axis.tolist():
                yield self.overrides[0] | {path: value}

    def coordinates(self) -> dict[str, xr.Variable]:
        """Return the coordinates of the result."""
        found = {name: xr.Variable(name, axis, _units(name)) for name, axis in self.axes.items()}
        if not self.gridded:
            (dim,) = self.axes
            for path in dict.fromkeys(path for override in self.overrides for path in override):
                values = [override.get(path, np.nan) for override in self.overrides]
                if all(isinstance(v, (int, float, str, np.number)) for v in values):
                    found[path] = xr.Variable(dim, np.array(values), _units(path))
        return found | {"seed": xr.Variable("seed", np.array(self.seeds))}


def _units(path: str) -> dict[str, str]:
    return {"units": unit_of(path)} if unit_of(path) else {}


def _seeds(seeds: int | Sequence[int]) -> tuple[int, ...]:
    found: tuple[int, ...] = ()
    if isinstance(seeds, Iterable):
        found = tuple(check_seed(s) for s in seeds)
    elif isinstance(seeds, int | np.integer) and not isinstance(seeds, bool):
        found = tuple(range(seeds))
    if not found or len(set(found)) < len(found):
        raise must_be("seeds", seeds, "a count or different numbers")
    return found


def points_of(points: Mapping[str, Any] | Sequence[Mapping[str, Any]], seeds: int | Sequence[int]) -> Points:
    """Return the points of ``{path: values, ...}`` (their grid) or of a list of overrides (one dim, ``point``).

    A list may name its dimension with an attribute ``dim``.
    """
    if not isinstance(points, (Mapping, Sequence)):
        raise must_be("points", points, "{path: values, ...} or a list")
    if len(points) == 0:
        raise FrictionloopError("points: needs one at least")
    if isinstance(points, Mapping):
        axes = {path: np.atleast_1d(np.asarray(values)) for path, values in points.items()}
        for path, axis in axes.items():
            if axis.ndim != 1 or axis.size == 0:
                raise FrictionloopError(f"{path}: needs a list, got shape {axis.shape}")
        values = itertools.product(*(axis.tolist() for axis in axes.values()))
        overrides = tuple(dict(zip(axes, point, strict=True)) for point in values)
        return Points(axes, overrides, _seeds(seeds), gridded=True)
    overrides = tuple(dict(point) for point in points)
    dim = getattr(points, "dim", "point")
    return Points({dim: np.arange(len(overrides))}, overrides, _seeds(seeds), gridded=False)


def fingerprint(
    system: System, points: Points, duration_s: float, score_from_s: float, metrics: Sequence[str], outside: str = ""
) -> str:
    """Return a digest of everything that is asked for in a sweep, so that only the same sweep is resumed.

    ``outside`` is the digest of blocks from outside (loop/blocks). What our own code computes from it is
    `kept.computing`.
    """
    described = system.model_dump(exclude={"board"})
    # A grid is told by its axes, in their order: they are a few dozen numbers where the points are thousands.
    asked_of = [(path, axis.tolist()) for path, axis in points.axes.items()] if points.gridded else points.overrides
    asked = [described, asked_of, points.seeds, duration_s, score_from_s, list(metrics), outside]
    return hashlib.sha256(json.dumps(asked, sort_keys=True, default=str).encode()).hexdigest()


def structures_of(
    system: System, grid: Points, duration_s: float, score_from_s: float, names: Sequence[str]
) -> list[object]:
    """Try every value of a sweep before anything runs and return the structure of each point."""
    read: set[tuple[Recording, float]] = set()

    def tried(override: dict[str, Any]) -> object:
        changed = system.evolve(override)
        periods = periods_in(changed, duration_s)
        scored = is_finite(score_from_s) and 0 <= score_from_s < duration_s
        if not (scored and round(score_from_s * changed.controller.rate_hz) < periods):
            raise must_be("score_from_s", score_from_s, f"0 to below duration_s = {duration_s!r}", "s")
        stepped = [name for name in names if getattr(METRICS[name], "tally", None) is STEP_TIMES]
        if stepped and changed.setpoint.kind != "steps":
            raise FrictionloopError(f"metric {stepped[0]}: needs setpoint.kind 'steps', not {changed.setpoint.kind!r}")
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
    # Whatever describes the plate may change how many segments a period has, and an effect is a program of its own.
    plain = not any(
        path.startswith(("plate.", "setpoint.effect", "setpoint.track")) or path.endswith(STRUCTURAL)
        for path in grid.axes
    )
    plain = plain and all(axis.dtype.kind in "if" for axis in grid.axes.values())
    plain = plain and sum(path.endswith(COUPLED) for path in grid.axes) < 2
    return probed[:1] * len(grid.overrides) if plain else [tried(override) for override in grid.overrides]
