"""The metrics of this package: which tally each reads, and what it makes of it.

r = f_r and f = f_a at the control periods t_k that count.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.loop.felt_tally import FELT
from frictionloop.loop.metric import Metric
from frictionloop.loop.step_tally import STEP_TIMES
from frictionloop.loop.tallies import ERRORS, REGRESSION, SHORTFALL


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


METRICS: dict[str, Any] = {
    "r2_identity": Metric(
        ERRORS, lambda s, n: 1.0 - s.error2 / _spread(s.r, s.r2, n), "1", "goodness of fit to f_a = f_r"
    ),
    "r2_regression": Metric(REGRESSION, _r2_regression, "1", "squared correlation of f_a on f_r"),
    "slope": Metric(REGRESSION, _slope, "1", "slope of the regression of f_a on f_r"),
    "rms_error": Metric(ERRORS, lambda s, n: np.sqrt(s.error2 / n), "N", "rms of f_a - f_r"),
    "saturation_index": Metric(ERRORS, lambda s, n: s.saturated / n, "1", "share of periods with a clamped command"),
    "output_noise": Metric(REGRESSION, lambda s, n: _std(s.f, s.f2, n), "N", "standard deviation of f_a"),
    "r2_bound": Metric(
        SHORTFALL,
        lambda s, n: 1.0 - s.shortfall2 / _spread(s.r, s.r2, n),
        "1",
        "best r2_identity any controller could reach",
    ),
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
