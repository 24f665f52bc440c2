"""How good a run is, in words: one row per metric with what it says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from frictionloop.cli.describe import Row
    from frictionloop.loop.step_times import StepTime

UNITS = {"intercept": "N", "rms_error": "N", "rms_error_turns": "N", "turn_peak": "N", "output_noise": "N"}
"""Units of the metrics that have one; the others are pure numbers."""
WORSE = 1.05
"""Share of the disturbance from which the loop is said to make it worse: above 1 by more than noise (chosen)."""


CLAMPED_MOST = 0.5
"""Share of clamped commands from which on what touch makes of a run is not the loop's."""

NOTHING_N = 1e-12
"""Force of rounding alone, as the error of an open loop that knows all of its finger (chosen)."""


def scored_periods(run: xr.Dataset, score_from_s: float = 0.0) -> np.ndarray:
    """Return which control periods count: from ``score_from_s`` on, without reversals and what is in the air."""
    late = run["time"].values >= score_from_s
    return late & run["scored"].values if "scored" in run else late


def metrics_of(run: xr.Dataset, score_from_s: float = 0.0) -> dict[str, float]:
    """Return every metric of a run by name, NaN where nothing counts or a metric has no meaning."""
    from frictionloop.loop.all_metrics import FELT, PLAIN, REGRESSION, TURNS, metrics

    mask = scored_periods(run, score_from_s)
    if not mask.any():
        return dict.fromkeys((*PLAIN, "disturbance_left", *REGRESSION, *TURNS, *FELT), math.nan)
    return metrics(run, mask)


def open_error_n(run: xr.Dataset, mask: np.ndarray) -> float:
    """Return the rms error of the same run under the lookup table alone, N; NaN where it is that, or not known."""
    from frictionloop.loop.metrics import rms_error
    from frictionloop.loop.open_loop import open_loop_of
    from frictionloop.loop.record import system_of

    opened = None if system_of(run).controller.kind == "lookup" or not mask.any() else open_loop_of(run)
    return math.nan if opened is None else rms_error(opened, mask)


def metric_rows(found: dict[str, float], opened_n: float = math.nan, rings: bool = False) -> list[Row]:
    """Return (metric, value with unit, what it says); of a constant set-point no R2, which it does not have.

    ``opened_n`` is the rms error in open loop, N; ``rings`` whether the loop rings by itself.
    """
    beside = "" if math.isnan(opened_n) else f"; {newtons(opened_n)} in open loop"
    missing = found["r2_bound"] - found["r2_identity"]
    offset = f"{'-' if found['intercept'] < 0 else '+'} {number(abs(found['intercept']))}"
    line = f"of the line f_a = {number(found['slope'])} f_r {offset} N"
    beyond = "" if math.isnan(missing) else f", {number(missing)} more"
    felt, relative = found["perceptual_index"], found["relative_index"]
    most = "the most any controller could reach" if math.isnan(relative) else "by reach alone, without delay and noise"
    bound = f"{most}{beyond}"
    if found["r2_bound"] < 0:
        bound = "below 0: reach alone misses f_r by more than f_r varies"
    turns_n = math.nan if math.isclose(found["rms_error_turns"], found["rms_error"]) else found["rms_error_turns"]
    rows: list[Row] = [
        ("r2_identity", number(found["r2_identity"]), "how well f_a follows f_r; 1 is perfect"),
        ("r2_bound", number(found["r2_bound"]), bound),
        ("r2_regression", number(found["r2_regression"]), line),
        ("rms_error", newtons(found["rms_error"]), f"rms of f_a - f_r{beside}"),
        ("with turns", newtons(turns_n), "the same with reversals and landings"),
        ("turn_peak", newtons(found["turn_peak"]), "largest force after a turn, mean of the turns"),
        *_left(found, rings),
        ("saturation_index", share(found["saturation_index"]), "share of the commands that were clamped"),
    ]
    rows = [row for row in rows if row[1] != "-"]
    if not math.isnan(relative):
        side, than = ("below 1: smoother" if relative < 1 else "above 1: rougher"), "than"
        if f"{relative:.3g}" == "1":
            side, than = "about 1: as rough", "as"
        said = f"{side} to touch, above all its fast part, {than} this stroke at a steady amplitude"
        if found["saturation_index"] > CLAMPED_MOST:
            said = "to touch, of this stroke at a steady amplitude; says little where most commands are clamped"
        rows.append(("relative_index", f"{relative:.3g}", said))
    if not math.isnan(felt):
        plain = "; no plain stroke of this finger both varies and has this mean force, so no relative_index"
        if not math.isnan(relative):
            plain = f"; that stroke at a steady amplitude has {felt / relative:.3g}" if relative > 0 else ""
        rows.append(("perceptual_index", f"{felt:.3g}", f"f_a - f_r in thresholds of touch{plain}"))
    return rows


def _left(found: dict[str, float], rings: bool) -> list[Row]:
    """Return the row that says what the loop leaves of a disturbance that varies, where that is known.

    Of a loop in its limit cycle it is the difference of two cycles out of step, with the disturbance and without.
    """
    left = found["disturbance_left"]
    if math.isnan(left):
        return []
    said = "share of the disturbance's variation that is left, rms; 1 as in open loop" + (
        "; the loop makes it worse" if left > WORSE else ""
    )
    if rings:
        said = "no share to quote: the loop rings by itself, with the disturbance and without"
    return [("disturbance_left", f"{left:.3g}", said)]


def scored_rows(mask: np.ndarray) -> list[Row]:
    """Return the row that says which share of a run counts, if not all of it does."""
    if mask.all():
        return []
    if not mask.any():
        return [("scored", "0 %", "all periods are at a reversal, lifted, or before --score-from-s")]
    return [
        (
            "scored",
            f"{100 * mask.mean():.3g} %",
            "of the periods; not those at reversals, lifted, or before --score-from-s",
        )
    ]


def step_rows(times: Sequence[StepTime], steps: int) -> list[Row]:
    """Return a row for the steps up and one for those down: mean times of those that were followed."""
    rows: list[Row] = []
    for name, some in (
        ("rise", [each for each in times if each.to_n > each.from_n]),
        ("fall", [each for each in times if each.to_n < each.from_n]),
    ):
        if some:
            to_63, rise = (1e3 * sum(column) / len(some) for column in zip(*(each[3:] for each in some), strict=True))
            rows.append(
                (name, f"{rise:.3g} ms", f"from 10 to 90 %; {to_63:.3g} ms to 63 %; mean of {_steps(len(some))}")
            )
    missed = steps - len(times)
    return [
        *rows,
        *([("not followed", _steps(missed), "90 % not reached in time, or around a reversal")] if missed else []),
    ]


def _steps(count: int) -> str:
    return f"{count} step{'s' * (count != 1)}"


def newtons(value: float) -> str:
    """Return a force in millinewtons, or a dash where there is none."""
    if abs(value) < NOTHING_N:
        return "0 mN"
    return "-" if math.isnan(value) else f"{value * 1e3:.4g} mN"


def between(low_n: float, high_n: float) -> str:
    """Return a range of forces, of one force that alone."""
    ends = f"{low_n:.3g}", f"{high_n:.3g}"
    return f"{ends[0]} N" if ends[0] == ends[1] else f"{ends[0]} to {ends[1]} N"


def share(value: float) -> str:
    """Return a share from 0 to 1."""
    return "-" if math.isnan(value) else f"{value:.4g}"


def number(value: float) -> str:
    """Return a metric to four decimals, or a dash where it has no meaning (a constant set-point has no R2)."""
    return "-" if math.isnan(value) else f"{value:.4f}" if abs(value) < 100 else f"{value:.4g}"
