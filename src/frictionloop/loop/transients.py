"""What the force does after a step of the set-point and after a turn: from a run, and as sums that a sweep keeps."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from frictionloop.loop.metric import Sample, Tally
from frictionloop.loop.record import system_of
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.scalar_math import fma, step

if TYPE_CHECKING:
    import xarray as xr


class StepTime(NamedTuple):
    """One step of the set-point that the force followed."""

    start_s: float
    from_n: float
    to_n: float
    to_63_s: float
    """From the step to 63 % of the way."""
    rise_s: float
    """From 10 to 90 % of the way."""


def step_times(run: xr.Dataset) -> list[StepTime]:
    """Return the times of every step of ``f_r`` whose 90 % ``f_a`` reached before the next step, a reversal or a lift.

    Way and times are counted from the old level of the set-point, first passages at control periods.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``, with a set-point of kind "steps".

    Raises
    ------
    FrictionloopError
        For a run without its System, or with a set-point of another kind.
    """
    kind = system_of(run).setpoint.kind
    if kind != "steps":
        raise FrictionloopError(f"step_times: needs setpoint.kind 'steps', not {kind!r}")
    time, r, f = (run[name].values for name in ("time", "f_r", "f_a"))
    scored = run["scored"].values if "scored" in run else np.ones(r.size, dtype=bool)
    starts = np.flatnonzero(np.diff(r)) + 1
    found: list[StepTime] = []
    for start, stop in zip(starts, np.append(starts, r.size)[1:], strict=True):
        low, high = float(r[start - 1]), float(r[start])
        way = (f[start:stop] - low) / (high - low)
        if way[0] >= 0.9:  # there already: it has not followed
            continue
        at = [_first(way >= share) for share in (0.1, 0.632, 0.9)]
        if None not in at and scored[start : start + at[2] + 1].all():  # type: ignore[operator]
            t10, t63, t90 = (time[start + k] - time[start] for k in at)  # type: ignore[operator]
            found.append(StepTime(float(time[start]), low, high, float(t63), float(t90 - t10)))
    return found


def _first(passed: np.ndarray) -> int | None:
    return int(np.argmax(passed)) if passed.any() else None


class Times(NamedTuple):
    """Steps that the force followed, and the sums of their times in control periods."""

    steps: float
    to_63: float
    from_10_to_90: float


class Following(NamedTuple):
    """The last step of the set-point, and what the ones before took."""

    period_s: float
    from_n: float
    to_n: float
    since: float
    """Periods since the step; then the first passages of 10 and 63 %, in the same unit, -1 before them."""
    at_10: float
    at_63: float
    open: float
    """1 until the passage of 90 %."""
    up: Times
    down: Times


@step
def added(times: Times, weight: float, at_63: float, rise: float) -> Times:
    """Add a step that counts ``weight``, 0 or 1."""
    return Times(times.steps + weight, fma(weight, at_63, times.to_63), fma(weight, rise, times.from_10_to_90))


@step
def follow(state: Following, sample: Sample, dt: float) -> Following:
    """Follow the force after a step of the set-point.

    A step that the next one, a reversal or a lift-off interrupts is not counted, nor one whose 90 % the force had
    passed before it was asked to.
    """
    period_s, from_n, to_n, since, at_10, at_63, follows, up, down = state
    to_n = to_n if period_s > 0.0 else sample.f_r  # the first level is no step
    stepped = sample.f_r != to_n
    from_n = to_n if stepped else from_n
    since = 0.0 if stepped else since + 1.0
    at_10, at_63 = -1.0 if stepped else at_10, -1.0 if stepped else at_63
    way, whole = (sample.f_a - from_n) * (1.0 if sample.f_r > from_n else -1.0), abs(sample.f_r - from_n)
    there = way >= 0.9 * whole
    follows = (0.0 if there else 1.0) if stepped else follows
    at_10 = since if (at_10 < 0.0) & (way >= 0.1 * whole) else at_10
    at_63 = since if (at_63 < 0.0) & (way >= 0.632 * whole) else at_63
    weight = sample.counts if (follows > 0.0) & there else 0.0
    follows = 0.0 if there | (sample.scored == 0.0) else follows
    rising = weight if sample.f_r > from_n else 0.0
    up, down = added(up, rising, at_63, since - at_10), added(down, weight - rising, at_63, since - at_10)
    return Following(dt, from_n, sample.f_r, since, at_10, at_63, follows, up, down)


STEP_TIMES = Tally("step_times", follow, Following, everywhere=True)


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
