"""The points of a sweep: a grid over dotted paths or a list of overrides, times seeds; tried before anything runs."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.kernel.tile_compatibility import COUPLED, STRUCTURAL, structure
from frictionloop.loop.metrics import METRICS
from frictionloop.loop.simulate import check_seed, is_finite, periods_in
from frictionloop.loop.transients import STEP_TIMES
from frictionloop.parameters import Recording, System
from frictionloop.parameters.population import read_population
from frictionloop.physics.fingers import DrawnFingers, Fingers
from frictionloop.physics.signal_values import sampler
from frictionloop.quantities import FrictionloopError, must_be, unit_of


class Grid(Sequence[dict[str, Any]]):
    """Every combination of values on axes, the last axis fastest, made where it is asked for."""

    def __init__(self, axes: dict[str, Sequence[Any]]) -> None:
        self.axes = axes
        self._count = math.prod(map(len, axes.values()))

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, place: Any) -> Any:
        if isinstance(place, slice):
            return [self[k] for k in range(*place.indices(self._count))]
        left, found = range(self._count)[place], dict[str, Any]()
        for path, values in reversed(self.axes.items()):
            left, at = divmod(left, len(values))
            found = override_of(path, values[at]) | found
        return found


def override_of(path: str, value: Any) -> dict[str, Any]:
    """Return the override of a value on an axis; that of a finger is one already."""
    return dict(value) if isinstance(value, Mapping) else {path: value}


@dataclass(frozen=True)
class Points:
    """Every override of a sweep in order, and the axes they lie on."""

    axes: dict[str, np.ndarray]
    overrides: Sequence[dict[str, Any]]
    seeds: tuple[int, ...]
    gridded: bool

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes, seeds last."""
        return (*(len(axis) for axis in self.axes.values()), len(self.seeds))

    def runs(self, lanes: Iterable[int]) -> list[tuple[dict[str, Any], int]]:
        """Return override and seed of lanes, numbered as the flattened result; one object for lanes of one point."""
        made: dict[int, dict[str, Any]] = {}
        found = []
        for lane in lanes:
            point, seed = divmod(lane, len(self.seeds))
            if point not in made:
                made = {point: self.overrides[point]}
            found.append((made[point], self.seeds[seed]))
        return found

    def probes(self, own: range) -> Iterator[dict[str, Any]]:
        """Yield overrides that try every value of some points once: of a grid each axis by itself, else all of them."""
        if not isinstance(self.overrides, Grid):
            yield from self.overrides[own.start : own.stop]
            return
        first, stride = self.overrides[own.start], len(self.overrides)
        for path, values in self.overrides.axes.items():
            stride //= len(values)
            reached = range(own.start // stride, (own.stop - 1) // stride + 1)
            for at in dict.fromkeys(each % len(values) for each in reached[: len(values)]):
                yield first | override_of(path, values[at])

    def coordinates(self) -> dict[str, xr.Variable]:
        """Return the coordinates of the result."""
        found = {name: xr.Variable(name, axis, units_of(name)) for name, axis in self.axes.items()}
        if not self.gridded:
            (dim,) = self.axes
            found |= self.columns(dim, range(len(self.overrides)))
        return found | {"seed": xr.Variable("seed", np.array(self.seeds))}

    def columns(self, dim: str, points: Iterable[int]) -> dict[str, xr.Variable]:
        """Return what some points of a list have of each path, over a dimension, where all are numbers or names."""
        some = [self.overrides[k] for k in points]
        found = {}
        for path in dict.fromkeys(path for override in some for path in override):
            values = [override.get(path, np.nan) for override in some]
            if all(isinstance(v, (int, float, str, np.number)) for v in values):
                found[path] = xr.Variable(dim, np.array(values), units_of(path))
        return found

    def identity(self) -> Any:
        """Return what tells these points from others, as JSON holds it: axes of a grid, and how fingers were drawn."""
        if not isinstance(self.overrides, Grid):
            return _identity(self.overrides)
        return [(path, _identity(values)) for path, values in self.overrides.axes.items()]


def _identity(values: Sequence[Any]) -> Any:
    if not isinstance(values, DrawnFingers):
        return [*values]
    population = values.drawn["population"]
    return {**values.drawn, "population": population and read_population(population).model_dump()}


def units_of(path: str) -> dict[str, str]:
    """Return the attributes that say the unit of a path."""
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

    A list may name its dimension with an attribute ``dim``; fingers may be one of the axes of a grid.
    """
    if not isinstance(points, (Mapping, Sequence)):
        raise must_be("points", points, "{path: values, ...} or a list")
    if len(points) == 0:
        raise FrictionloopError("points: needs one at least")
    if isinstance(points, Mapping):
        fingers = {path: values for path, values in points.items() if isinstance(values, Fingers) and len(values)}
        axes = {path: np.atleast_1d(np.asarray(values)) for path, values in points.items() if path not in fingers}
        for path, axis in axes.items():
            if axis.ndim != 1 or axis.size == 0:
                raise FrictionloopError(f"{path}: needs a list, got shape {axis.shape}")
        values = {path: fingers[path] if path in fingers else axes[path].tolist() for path in points}
        axes = {path: axes.get(path, np.arange(len(each))) for path, each in values.items()}
        return Points(axes, Grid(values), _seeds(seeds), gridded=True)
    overrides = points if isinstance(points, Fingers) else tuple(dict(point) for point in points)
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
    asked = [described, points.identity(), points.seeds, duration_s, score_from_s, list(metrics), outside]
    return hashlib.sha256(json.dumps(asked, sort_keys=True, default=str).encode()).hexdigest()


def _has_fingers(grid: Points) -> bool:
    return isinstance(grid.overrides, Grid) and any(isinstance(each, Fingers) for each in grid.overrides.axes.values())


def structures_of(
    system: System, grid: Points, own: range, duration_s: float, score_from_s: float, names: Sequence[str]
) -> Sequence[object]:
    """Try every value of some points before anything runs and return the structure of each point."""
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
    probed = [tried(override) for override in grid.probes(own)]
    if not grid.gridded:
        return probed
    # Whatever describes the plate may change how many segments a period has, and an effect is a program of its own.
    plain = not any(
        path.startswith(("plate.", "setpoint.effect", "setpoint.track")) or path.endswith(STRUCTURAL)
        for path in grid.axes
    )
    plain = plain and all(axis.dtype.kind in "if" for axis in grid.axes.values()) and not _has_fingers(grid)
    plain = plain and sum(path.endswith(COUPLED) for path in grid.axes) < 2
    return probed[:1] * len(own) if plain else [tried(grid.overrides[k]) for k in own]
