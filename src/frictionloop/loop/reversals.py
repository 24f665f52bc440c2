"""What is left out where periods are scored: the error with turns, the force after one, how long feedback acts."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from frictionloop.loop.metric import Sample, Tally
from frictionloop.quantities.arithmetic import fma, step

if TYPE_CHECKING:
    import xarray as xr

TURNED_M = 1e-3
"""Way back from the farthest place that is a turn, more than any tremor goes (physics/fingers)."""
PEAK_S = 0.25
"""Time from there in which the largest force is that of the turn: at 5 mm/s friction has turned over."""
SLIDING_M_S = 2e-3
"""Least speed of a finger that slides (as ``touch.load.least_speed_mm_s``)."""
LOOK_S = 5e-3
"""Time between the places of a run by which turns are found: tremor of 10 Hz goes 0.1 mm meanwhile."""


class Reversals(NamedTuple):
    """Sums over all periods in contact from the first that counts on, and what the last turn has done."""

    counting: float
    periods: float
    error2: float
    slid: float
    fed: float
    """Periods that slide, and those of them with a valid reading."""
    direction: float
    farthest_m: float
    since_s: float
    """Time since the last turn; 0 where there is none to look at."""
    peak_n: float
    peaks_n: float
    turns: float


@step
def add_reversals(state: Reversals, sample: Sample, dt: float) -> Reversals:
    """Add a period."""
    counting, periods, error2, slid, fed, direction, farthest, since, peak, peaks, turns = state
    counting = max(counting, sample.counts)
    # A finger that nobody moves has no load, and always counts.
    weight = counting if (sample.load > 0.0) | (sample.scored > 0.0) else 0.0
    error, slides = sample.f_a - sample.f_r, weight if abs(sample.speed) >= SLIDING_M_S else 0.0
    begins = direction == 0.0
    direction = (1.0 if sample.speed >= 0.0 else -1.0) if begins else direction
    ahead = direction * (sample.position - farthest)
    turned = (ahead < -TURNED_M) & (not begins)
    farthest = sample.position if begins | turned | (ahead > 0.0) else farthest
    direction = -direction if turned else direction
    over = (since > 0.0) & (turned | (since >= PEAK_S))
    peaks, turns = peaks + peak if over else peaks, turns + 1.0 if over else turns
    since = counting * dt if turned else (0.0 if over | (since == 0.0) else since + dt)
    peak = sample.f_a if turned else max(peak, sample.f_a)
    return Reversals(
        counting, periods + weight, fma(weight * error, error, error2), slid + slides, fma(slides, sample.valid, fed),
        direction, farthest, since, peak, peaks, turns,
    )  # fmt: skip


REVERSALS = Tally("reversals", add_reversals, Reversals, everywhere=True)


def reversal_metrics(run: xr.Dataset, keep: np.ndarray) -> dict[str, float]:
    """Return the metrics of `Reversals` of a run by name, NaN where there is no turn, or nothing slides.

    Parameters
    ----------
    run
        From ``simulate`` or ``load``.
    keep
        The control periods that count, bool, shape (time,).
    """
    time_s, f_a = run["time"].values, run["f_a"].values
    since = np.arange(time_s.size) >= np.argmax(keep)
    there, peaks, fed = since, [], np.zeros(0)
    if "load" in run:
        there = since & ((run["load"].values > 0.0) | run["scored"].values)
        fed = run["sliding"].values[there & (np.abs(run["speed"].values) >= SLIDING_M_S)]
        starts = _turns_s(time_s, run["position"].values)
        ends = [min(t + PEAK_S, after) for t, after in zip(starts, [*starts[1:], np.inf], strict=False)]
        counted = [(t, end) for t, end in zip(starts, ends, strict=True) if t >= time_s[since][0] and end < time_s[-1]]
        peaks = [f_a[(time_s >= t) & (time_s < end)].max() for t, end in counted]
    error = (f_a - run["f_r"].values)[there]
    return {
        "rms_error_turns": float(np.sqrt(np.mean(error**2))),
        "turn_peak": float(np.mean(peaks)) if peaks else np.nan,
        "feedback_share": float(np.mean(fed)) if fed.size else np.nan,
    }


def _turns_s(time_s: np.ndarray, position_m: np.ndarray) -> list[float]:
    """Return when the finger is back from a farthest place by `TURNED_M`."""
    every = max(round(LOOK_S / (time_s[1] - time_s[0])), 1) if time_s.size > 1 else 1
    places = position_m[::every]
    found: list[float] = []
    farthest, direction = places[0], 1.0 if places.size < 2 or places[1] >= places[0] else -1.0
    for t, x in zip(time_s[::every], places, strict=True):
        if direction * (x - farthest) < -TURNED_M:
            found.append(float(t))
            direction, farthest = -direction, x
        farthest = direction * max(direction * x, direction * farthest)
    return found
