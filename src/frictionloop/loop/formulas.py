"""The metrics of this package: the sums that the kernel keeps, and what each metric makes of them.

r = f_r and f = f_a at the control periods t_k that count. Sums are of both less a constant near their mean, so that
differences of squares keep their digits.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from frictionloop.loop.felt_tally import FELT
from frictionloop.loop.metric import AgainMetric, Metric, Sample, Tally
from frictionloop.loop.reversals import REVERSALS
from frictionloop.loop.step_times import STEP_TIMES
from frictionloop.quantities.arithmetic import fma, step


class Errors(NamedTuple):
    """Squares of the error f_a - f_r, f_r and its squares, and periods with a clamped command."""

    shift: float
    error2: float
    r: float
    r2: float
    saturated: float


@step
def add_errors(state: Errors, sample: Sample, dt: float) -> Errors:
    """Add a period."""
    shift, error2, r_sum, r2, saturated = state
    error, r = sample.f_a - sample.f_r, sample.f_r - shift
    return Errors(shift, fma(error, error, error2), r_sum + r, fma(r, r, r2), saturated + sample.saturated)


class Regression(NamedTuple):
    """f_r and f_a, their squares and their products."""

    shift: float
    r: float
    r2: float
    f: float
    f2: float
    fr: float


@step
def add_regression(state: Regression, sample: Sample, dt: float) -> Regression:
    """Add a period."""
    shift, r_sum, r2, f_sum, f2, fr = state
    r, f = sample.f_r - shift, sample.f_a - shift
    return Regression(shift, r_sum + r, fma(r, r, r2), f_sum + f, fma(f, f, f2), fma(f, r, fr))


class Shortfall(NamedTuple):
    """f_r, its squares, and those of what no command could make up for: f_r clipped to what is reachable, less f_r."""

    shift: float
    r: float
    r2: float
    shortfall2: float


@step
def add_shortfall(state: Shortfall, sample: Sample, dt: float) -> Shortfall:
    """Add a period."""
    shift, r_sum, r2, shortfall2 = state
    r, short = sample.f_r - shift, min(max(sample.f_r, sample.floor + sample.d), sample.limit + sample.d) - sample.f_r
    return Shortfall(shift, r_sum + r, fma(r, r, r2), fma(short, short, shortfall2))


def _from(shape: Any) -> Any:
    """Return the start of sums: none yet, less the offset of the set-point."""
    return lambda setpoint, rate_hz: shape(getattr(setpoint, "offset_n", 0.0), *[0.0] * (len(shape._fields) - 1))


ERRORS = Tally("errors", add_errors, Errors, _from(Errors))
REGRESSION = Tally("regression", add_regression, Regression, _from(Regression))
SHORTFALL = Tally("shortfall", add_shortfall, Shortfall, _from(Shortfall))
TALLIES = (ERRORS, REGRESSION, SHORTFALL, STEP_TIMES, FELT, REVERSALS)


def _spread(sum_: Any, squares: Any, count: Any) -> Any:
    """Return sum (x - mean x)^2, NaN where x is constant (a goodness of fit has no meaning there)."""
    spread = squares - sum_ * sum_ / count
    # What is left of the squares of a constant is their rounding.
    return np.where(spread > 1e-12 * squares, spread, np.nan)


def _std(sum_: Any, squares: Any, count: Any) -> Any:
    return np.sqrt(np.maximum(squares / count - (sum_ / count) ** 2, 0.0))


def _slope(s: Any, count: Any) -> Any:
    return (s.fr - s.f * s.r / count) / _spread(s.r, s.r2, count)


def _r2_regression(s: Any, count: Any) -> Any:
    return _slope(s, count) * ((s.fr - s.f * s.r / count) / _spread(s.f, s.f2, count))


def _mean_s(way: str, what: str) -> Any:
    """Return the formula of a mean time of the steps up or down in s, NaN where there was none."""

    def of(s: Any, count: Any) -> Any:
        times = getattr(s, way)
        return np.where(times.steps > 0, getattr(times, what) / np.maximum(times.steps, 1.0), np.nan) * s.period_s

    return of


def _per(sum_: Any, count: Any) -> Any:
    """Return a mean, NaN of nothing."""
    return np.where(count > 0.0, sum_ / np.maximum(count, 1.0), np.nan)


def _left(run: Any, mask: Any) -> float:
    from frictionloop.loop.open_loop import disturbance_left  # which runs, and so needs the metrics

    return disturbance_left(run, mask)


METRICS: dict[str, Any] = {
    "r2_identity": Metric(
        ERRORS, lambda s, n: 1.0 - s.error2 / _spread(s.r, s.r2, n), "1", "goodness of fit to f_a = f_r"
    ),
    "r2_regression": Metric(REGRESSION, _r2_regression, "1", "squared correlation of f_a on f_r"),
    "slope": Metric(REGRESSION, _slope, "1", "slope of the regression of f_a on f_r"),
    "rms_error": Metric(ERRORS, lambda s, n: np.sqrt(s.error2 / n), "N", "rms of f_a - f_r where scored"),
    "rms_error_turns": Metric(
        REVERSALS, lambda s, n: np.sqrt(_per(s.error2, s.periods)), "N", "rms of f_a - f_r with turns and landings"
    ),
    "turn_peak": Metric(REVERSALS, lambda s, n: _per(s.peaks_n, s.turns), "N", "largest f_a after a turn, mean"),
    "feedback_share": Metric(REVERSALS, lambda s, n: _per(s.fed, s.slid), "1", "share of sliding with feedback"),
    "saturation_index": Metric(ERRORS, lambda s, n: s.saturated / n, "1", "share of periods with a clamped command"),
    "output_noise": Metric(REGRESSION, lambda s, n: _std(s.f, s.f2, n), "N", "standard deviation of f_a"),
    "r2_bound": Metric(
        SHORTFALL,
        lambda s, n: 1.0 - s.shortfall2 / _spread(s.r, s.r2, n),
        "1",
        "best r2_identity any controller could reach",
    ),
    "disturbance_left": AgainMetric(_left, "1", "share of the disturbance's variation that is left in f_a, rms"),
    "perceptual_index": Metric(
        FELT, lambda s, n: np.sqrt(s.felt2 / n), "1", "residual over its threshold, rms: felt above 1"
    ),
    "rise_63_s": Metric(STEP_TIMES, _mean_s("up", "to_63"), "s", "mean time to 63 % of a step up"),
    "rise_10_90_s": Metric(STEP_TIMES, _mean_s("up", "from_10_to_90"), "s", "mean time from 10 to 90 % up"),
    "fall_63_s": Metric(STEP_TIMES, _mean_s("down", "to_63"), "s", "mean time to 63 % of a step down"),
    "fall_10_90_s": Metric(
        STEP_TIMES, _mean_s("down", "from_10_to_90"), "s", "mean time from 10 to 90 % of a step down"
    ),
    "mean_force": Metric(REGRESSION, lambda s, n: s.shift + s.f / n, "N", "mean of f_a"),
    "mean_setpoint": Metric(ERRORS, lambda s, n: s.shift + s.r / n, "N", "mean of f_r"),
    "setpoint_spread": Metric(ERRORS, lambda s, n: _std(s.r, s.r2, n), "N", "standard deviation of f_r"),
    "scored_periods": Metric(ERRORS, lambda s, n: n, "1", "control periods that count"),
}
"""Every metric by name; those that are registered from outside too (loop/metric)."""
DEFAULT_METRICS = ("r2_identity", "rms_error", "saturation_index")
