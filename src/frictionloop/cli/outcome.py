"""What a sweep found: how much is done, the best point of each metric, the whole as JSON or as a table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.cli import describe, screen
from frictionloop.loop.open_loop import OPEN_ERROR
from frictionloop.loop.record import load
from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError

SMALLEST = (
    "rms_error",
    "rms_error_turns",
    "turn_peak",
    OPEN_ERROR,
    "saturation_index",
    "disturbance_left",
    "output_noise",
    "perceptual_index",
    "rise_63_s",
    "rise_10_90_s",
    "fall_63_s",
    "fall_10_90_s",
)
"""Metrics whose smallest value is the best; of the slope it is the one nearest to 1, of the others the largest."""
DESCRIPTIVE = ("mean_force", "mean_setpoint", "setpoint_spread", "scored_periods", "feedback_share")
"""Metrics that say what a run was; no value of theirs is the best."""
VALUELESS = {
    **dict.fromkeys(("r2_identity", "r2_regression", "r2_bound", "slope"), "a constant set-point has none"),
    "disturbance_left": "the disturbance does not vary",
}
"""Why no run has a value of a metric."""
FEW = 12
"""Points that are listed one by one; more are for --csv and --plot (chosen)."""


def compiled(system: System, points: Any, seeds: int, metrics: Sequence[str] | None) -> None:
    """Compile the loop for tiles of lanes, or load it, so that a sweep's time is that of its runs.

    What is wrong with the first point is left to the sweep to say, which then has nothing to wait for.
    """
    if isinstance(points, Mapping):
        first, count = {path: values[0] for path, values in points.items()}, math.prod(map(len, points.values()))
    else:
        first, count = points[0], len(points)
    with suppress(FrictionloopError):
        sweep(system, [first] * min(seeds * count, 3), 1 / system.controller.rate_hz, 1, metrics, progress=False)


def check_finished(path: Path) -> None:
    """Refuse to start over in a file that keeps an unfinished sweep."""
    if not path.is_file():
        return
    try:
        kept = load(path)
    except FrictionloopError:
        return
    if "fingerprint" in kept.attrs and _runs_with_values(kept) < np.prod(list(kept.sizes.values())):
        raise FrictionloopError(
            f"{path}: keeps an unfinished sweep; add --resume to continue it, or choose another --out"
        )


def _runs_with_values(result: xr.Dataset) -> int:
    """Return how many runs are done: one that is has some metric, though R2 of a constant set-point is NaN."""
    numbers = [values.values for values in result.data_vars.values() if values.dtype.kind == "f"]
    return int(np.any(~np.isnan(numbers), axis=0).sum()) if numbers else 0


def loss_of(metric: str, values: np.ndarray) -> np.ndarray:
    """Return values of a metric turned so that the smallest is the best."""
    return values if metric in SMALLEST else abs(values - 1) if metric == "slope" else -values


def shown(value: float, units: str, spread: float | None = None) -> str:
    """Return a value for a person, newtons as mN and seconds as ms."""
    factor, unit = {"N": (1e3, " mN"), "s": (1e3, " ms")}.get(units, (1.0, ""))
    return f"{value * factor:.4g}" + ("" if spread is None else f" ± {spread * factor:.1g}") + unit


def left_out(result: xr.Dataset) -> dict[str, str]:
    """Return the metrics of which no run has a value, and a line on each; none where nothing has run."""
    without = [str(name) for name, values in result.data_vars.items() if not np.any(np.isfinite(values.values))]
    if len(without) == len(result.data_vars):
        return {}
    return {name: f"{name} is left out: {VALUELESS.get(name, 'no run has a value of it')}" for name in without}


@dataclass(frozen=True)
class Best:
    """The best point of one metric; ``others`` are as good."""

    metric: str
    value: float
    spread: float
    point: dict[str, Any]
    at_end: tuple[str, ...]
    others: int


class Outcome:
    """A result of ``sweep``, perhaps not complete, and how long it took."""

    opened = True
    """Whether nobody interrupted the runs in open loop beside it."""

    def __init__(self, result: xr.Dataset, elapsed_s: float, complete: bool) -> None:
        self.result, self.elapsed_s, self.complete = result, elapsed_s, complete
        self.axes = [str(dim) for dim in result.dims if dim != "seed"]
        self.seeds = result.sizes["seed"]
        self.total = int(np.prod(list(result.sizes.values())))
        self.done = self.total if complete else _runs_with_values(result)

    @property
    def few(self) -> bool:
        """Tell whether these are few points, which are listed one by one."""
        return math.prod(self.result.sizes[path] for path in self.axes) <= FEW

    def best(self, metric: str) -> Best | None:
        """Return the best point by the mean over seeds, None where no run has a value."""
        values = self.result[metric].transpose(*self.axes, "seed").values
        good = ~np.isnan(values)
        count = good.sum(axis=-1)
        mean = np.where(count > 0, np.where(good, values, 0.0).sum(axis=-1) / np.maximum(count, 1), np.nan)
        if np.isnan(mean).all():
            return None
        loss = loss_of(metric, mean)
        at = np.unravel_index(np.nanargmin(loss), loss.shape)
        others = int(np.sum(loss == loss[at])) - 1
        point = {path: self.result[path].values[k].item() for path, k in zip(self.axes, at, strict=True)}
        sizes = zip(self.axes, at, loss.shape, strict=True)
        at_end = tuple(path for path, k, size in sizes if size > 2 and k in (0, size - 1) and not others)
        return Best(metric, float(mean[at]), float(np.nanstd(values[at])), point, at_end, others)

    def summary(self, duration_s: float) -> list[Any]:
        """Return what a person is shown."""
        rows: list[describe.Row] = [("best", "value", "at")]
        judged = {str(name): values for name, values in self.result.data_vars.items() if name not in DESCRIPTIVE}
        for name, values in judged.items():
            rows.append(self._row(name, values.attrs.get("units", "1"), self.best(name)))
        ends = any(best and best.at_end for best in map(self.best, judged)) and not self.few
        sizes = " x ".join(str(self.result.sizes[path]) for path in self.axes)
        of = f"{sizes} points" + (f" x {self.seeds} seeds" if self.seeds > 1 else "")
        return [
            screen.columns(rows),
            *(["* at the end of its range: the best may lie beyond"] if ends else []),
            "",
            self.work(of, duration_s),
        ]

    def work(self, of: str, duration_s: float) -> str:
        """Return the line that says how much was run."""
        return f"{of} of {duration_s:g} s, {self.done} of {self.total} runs done, in {screen.seconds(self.elapsed_s)}"

    def _row(self, name: str, units: str, best: Best | None) -> describe.Row:
        if best is None:
            return name, "-", "no run has a value"
        value = shown(best.value, units, best.spread if self.seeds > 1 else None)
        ends = () if self.few else best.at_end
        where = ", ".join(
            f"{path}={describe.short(at)}{'*' if path in ends else ''}" for path, at in best.point.items()
        )
        also = f" and {best.others} other point{'s' * (best.others > 1)}" if best.others else ""
        return name, value, where + also

    def as_json(self) -> dict[str, Any]:
        """Return everything: axes, values in the order of ``dims``, best points, whether it is complete."""
        variables = self.result.data_vars.items()
        bests = [best for name, _ in variables if name not in DESCRIPTIVE and (best := self.best(str(name)))]
        return {
            "dims": [*self.axes, "seed"],
            "axes": {path: self.result[path].values for path in self.axes},
            "seeds": self.result["seed"].values,
            "metrics": {name: values.transpose(*self.axes, "seed").values for name, values in variables},
            "units": {name: values.attrs["units"] for name, values in variables if values.attrs["units"] != "1"},
            "best": {best.metric: {"value": best.value, "point": best.point} for best in bests},
            "runs_done": self.done,
            "runs": self.total,
            "complete": self.done == self.total,
            "elapsed_s": self.elapsed_s,
        }

    def table(self) -> Any:
        """Return one row per run: the point, the seed, the metrics."""
        return self.result.to_dataframe(dim_order=[*self.axes, "seed"]).reset_index()
