"""What a sweep found: how much of it is done, the best point of each metric, and whether its loop rings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis.stability import NEAR
from frictionloop.design.grid_corners import peak_of
from frictionloop.findings import Finding, Result, shown
from frictionloop.findings.result import Figure, Row, Table, Tables, frame, plain
from frictionloop.loop.companion_runs import OPEN_ERROR
from frictionloop.loop.record import system_of
from frictionloop.loop.sweep_checkpoint import runs_done
from frictionloop.parameters import System
from frictionloop.parameters.doubtful_values import of_axes, of_ceiling
from frictionloop.quantities import FrictionloopError

SMALLEST = (
    *("rms_error", "rms_error_turns", "turn_peak", OPEN_ERROR, "saturation_index", "disturbance_left", "output_noise"),
    *("perceptual_index", "rise_63_s", "rise_10_90_s", "fall_63_s", "fall_10_90_s"),
)
"""Metrics whose smallest value is the best; of the slope it is the one nearest to 1, of the others the largest."""
DESCRIPTIVE = ("mean_force", "mean_setpoint", "setpoint_spread", "scored_periods", "feedback_share")
"""Metrics that say what a run was; no value of theirs is the best."""
CONSTANT = ("r2_identity", "r2_regression", "r2_bound", "slope")
"""Metrics of which a constant set-point has none."""
FEW = 12
"""Points that are listed one by one (chosen)."""
FIRST = 4
"""Metrics whose best points stand in the answer's rows beside listed points (chosen)."""
SMALL = {"N": (1e3, "mN"), "s": (1e3, "ms")}
"""How a unit is shown."""


@dataclass(frozen=True)
class Best:
    """The best point of one metric, by the mean over seeds."""

    metric: str
    value: float
    unit: str
    spread: float
    """Standard deviation over seeds."""
    point: Mapping[str, Any]
    at_end: tuple[str, ...]
    """Paths of which it lies at the end of the values."""
    others: int
    """How many more points are as good."""
    sensitivity_peak: float
    """Largest Ms of its loop: infinite if it is unstable, NaN if it has no linear analysis."""

    def to_dict(self) -> dict[str, Any]:
        """Return it by name, and whether its loop is stable."""
        return {**asdict(self), "stable": _stable(self.sensitivity_peak)}


@dataclass(frozen=True, kw_only=True)
class GridResult(Result, without="grid"):
    """What runs over a grid found, all of them or those that are done."""

    system: System
    grid: xr.Dataset
    """Metrics over the grid and ``seed``, with coordinates."""
    runs: int
    runs_done: int

    @property
    def complete(self) -> bool:
        """Whether all runs are done."""
        return self.runs_done == self.runs

    def _runs(self, size: str) -> Row:
        seeds = f" x {self.grid.sizes['seed']} seeds" * (self.grid.sizes["seed"] > 1)
        duration = shown(float(self.grid.attrs.get("duration_s", math.nan)))
        return "runs", f"{self.runs_done} of {self.runs}: {size}{seeds} of {duration} s"

    def tidy(self) -> Table:
        """Return a row for each run: the point, the seed, the metrics."""
        dims = [*(str(dim) for dim in self.grid.dims if dim != "seed"), "seed"]
        return self.grid.to_dataframe(dim_order=dims).reset_index()

    def plot(self) -> Figure:
        """Return curves over one parameter, maps over two or three; points of fingers, sorted."""
        from frictionloop.loop.sweep_figure import figure_of

        return figure_of(self.grid)

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name: axes, metrics in the order of ``dims``, and units too."""
        grid = self.grid
        dims = [*(str(dim) for dim in grid.dims if dim != "seed"), "seed"]
        variables = {str(name): values for name, values in grid.data_vars.items()}
        more = {
            "complete": self.complete,
            "dims": dims,
            "axes": {dim: grid[dim].values for dim in dims[:-1]},
            "seeds": grid["seed"].values,
            "metrics": {name: values.transpose(*dims).values for name, values in variables.items()},
            "units": {name: unit for name in variables if (unit := _unit(grid, name)) != "1"},
            **{name: grid.attrs.get(name) for name in ("duration_s", "score_from_s")},
        }
        return super().to_dict() | plain(more)


class SweepSummary(GridResult, schema="sweep/1"):
    """What a sweep found."""

    best: Mapping[str, Best]
    """By metric; those without a value, and those that only describe a run, have none."""
    peaks: np.ndarray | None
    """Largest Ms at every point of a few, as `Best.sensitivity_peak`; None of many."""

    @property
    def axes(self) -> tuple[str, ...]:
        """Dotted paths that vary, or "point"."""
        return tuple(str(dim) for dim in self.grid.dims if dim != "seed")

    def rows(self) -> list[Row]:
        """Return the best points and how much has run."""
        first = list(self.best.values())[: FIRST if self.peaks is not None else 1]
        size = " x ".join(str(self.grid.sizes[axis]) for axis in self.axes)
        return [
            *((f"best {each.metric}", f"{_value(each)}   {_point(each)}") for each in first),
            self._runs(f"{size} points"),
        ]

    def tables(self) -> Tables:
        """Return the points of a few, and the best of each metric."""
        best = {"best": self._best()} if self.best else {}
        return best if self.peaks is None else {"points": self._points()} | best

    def _points(self) -> Table:
        assert self.peaks is not None
        rows = []
        for k, at in enumerate(product(*(range(self.grid.sizes[axis]) for axis in self.axes))):
            here = self.grid.isel(dict(zip(self.axes, at, strict=True)))
            row: dict[str, Any] = {axis: here[axis].item() for axis in self.axes}
            for name in _metrics(self.grid):
                factor, unit = SMALL.get(_unit(self.grid, name), (1.0, ""))
                row[f"{name}, {unit}" if unit else name] = factor * float(here[name].mean())
            rows.append(row | {"Ms": float(self.peaks[k])})
        return frame(rows, self.axes[0])

    def _best(self) -> Table:
        rows = [
            {"best": each.metric, "value": _value(each), **each.point, "as good": each.others}
            | {"Ms": each.sensitivity_peak}
            for each in self.best.values()
        ]
        return frame(rows, "best")

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, and which points are stable."""
        stable = None if self.peaks is None else [_stable(float(each)) for each in self.peaks]
        return super().to_dict() | {"stable": stable}


def best(grid: xr.Dataset) -> SweepSummary:
    """Return the best point of each metric of a sweep, and whether the loops there ring.

    Parameters
    ----------
    grid
        From `sweep`, or what `SweepInterrupted` carries: what has not run is left out.

    Raises
    ------
    FrictionloopError
        For a Dataset that is no sweep.
    """
    system = system_of(grid)
    if "seed" not in grid.dims:
        raise FrictionloopError("grid: must be of fl.sweep", "UNKNOWN-NAME")
    axes = [str(dim) for dim in grid.dims if dim != "seed"]
    total, done = int(np.prod(list(grid.sizes.values()))), runs_done(grid)
    names = [name for name in _metrics(grid) if name not in DESCRIPTIVE]
    peaks = _peaks(system, grid, axes)
    found = {name: each for name in names if (each := _best_of(grid, axes, name, peaks)) is not None}
    few = math.prod(grid.sizes[axis] for axis in axes) <= FEW
    return SweepSummary(
        system=system,
        grid=grid,
        best=found,
        peaks=np.array([peaks(at) for at in np.ndindex(*(grid.sizes[axis] for axis in axes))]) if few else None,
        runs=total,
        runs_done=done,
        findings=tuple(_findings(system, grid, found, few)),
    )


Peaks = Callable[[tuple[int, ...]], float]
"""From the place of a point of a sweep to the largest Ms of its loop."""


def _peaks(system: System, grid: xr.Dataset, axes: list[str]) -> Peaks:
    """Return what looks for the peak at each point once."""
    paths = axes if axes != ["point"] else [str(name) for name in grid.coords if "." in str(name)]

    @cache
    def peak(at: tuple[int, ...]) -> float:
        here = grid.isel(dict(zip(axes, at, strict=True)))
        return peak_of(system.evolve({path: here[path].item() for path in paths}))

    return peak


def _best_of(grid: xr.Dataset, axes: list[str], metric: str, peaks: Peaks) -> Best | None:
    """Return the best point of a metric, None where no run has a value."""
    values = grid[metric].transpose(*axes, "seed").values
    good = ~np.isnan(values)
    count = good.sum(axis=-1)
    mean = np.where(count > 0, np.where(good, values, 0.0).sum(axis=-1) / np.maximum(count, 1), np.nan)
    if np.isnan(mean).all():
        return None
    loss = loss_of(metric, mean)
    at = tuple(int(k) for k in np.unravel_index(np.nanargmin(loss), loss.shape))
    others = int(np.sum(loss == loss[at])) - 1
    ends = tuple(path for path, k, size in zip(axes, at, loss.shape, strict=True) if size > 2 and k in (0, size - 1))
    point = {axis: grid[axis].values[k].item() for axis, k in zip(axes, at, strict=True)}
    about = (point, () if others else ends, others, peaks(at))
    return Best(metric, float(mean[at]), _unit(grid, metric), float(np.nanstd(values[at])), *about)


def loss_of(metric: str, values: np.ndarray) -> np.ndarray:
    """Return values of a metric turned so that the smallest is the best."""
    return values if metric in SMALLEST else abs(values - 1) if metric == "slope" else -values


def _findings(system: System, grid: xr.Dataset, found: Mapping[str, Best], few: bool) -> Iterator[Finding]:
    total, done = int(np.prod(list(grid.sizes.values()))), runs_done(grid)
    if done < total:
        yield Finding("STOPPED", value=done, limit=total)
    first = next(iter(found.values()), None)
    if first is not None and first.sensitivity_peak >= NEAR:
        yield Finding(
            "BEST-RINGS", value=first.sensitivity_peak, remedy=dict(first.point), more={"metric": first.metric}
        )
    ends = {path: each.point[path] for each in found.values() for path in each.at_end}
    if ends and not few:
        yield Finding("BEST-AT-END", value=ends)
    yield from without_value(system, grid)
    paths = [str(dim) for dim in grid.dims if "." in str(dim)]
    yield from of_axes({path: grid[path].values.tolist() for path in paths})
    yield from of_ceiling(system)


def without_value(system: System, grid: xr.Dataset) -> Iterator[Finding]:
    """Yield the metrics of which no run has a value; none where nothing has run."""
    names = _metrics(grid)
    without = [name for name in names if not np.any(np.isfinite(grid[name].values))]
    blocks: dict[str, list[str]] = {}
    for name in without if len(without) < len(names) or runs_done(grid) else ():
        block = "disturbance" if name == "disturbance_left" else "setpoint" if name in CONSTANT else ""
        blocks.setdefault(block, []).append(name)
    for block, those in blocks.items():
        reason = f"{block}.kind {getattr(system, block).kind}" if block else "nothing is scored"
        yield Finding("METRIC-NONE", value=those, more={"reason": reason})


def _metrics(grid: xr.Dataset) -> list[str]:
    return [str(name) for name, values in grid.data_vars.items() if values.dtype.kind == "f"]


def _unit(grid: xr.Dataset, metric: str) -> str:
    return str(grid[metric].attrs.get("units", "1"))


def _stable(peak: float) -> bool | None:
    return None if math.isnan(peak) else math.isfinite(peak)


def _value(best: Best) -> str:
    factor, unit = SMALL.get(best.unit, (1.0, ""))
    return f"{shown(factor * best.value, 4)} {unit}".rstrip()


def _point(best: Best) -> str:
    at = "   ".join(f"{path} {shown(value, 6)}" for path, value in best.point.items())
    also = f"   and {best.others} more" * bool(best.others)
    return at + also + f"   Ms {shown(best.sensitivity_peak)}" * (not math.isnan(best.sensitivity_peak))
