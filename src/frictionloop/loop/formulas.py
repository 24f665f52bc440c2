"""The formulas of the metrics, from the sums over the scored periods that a run or a sweep gives.

r = f_r and f = f_a at the control periods t_k; sums are of r and f minus a constant near their mean, so that
differences of squares keep their digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from frictionloop.loop.kernel.score_tile import BOUND, IDENTITY, PERCEPTION, REGRESSION, SATURATION, STEPS


class Sums(NamedTuple):
    """Sums over the scored periods, each a number or an array over lanes."""

    error2: Any
    r: Any
    r2: Any
    saturated: Any
    f: Any
    f2: Any
    fr: Any
    shortfall2: Any
    count: Any
    felt2: Any = np.nan
    """Squares of the residual over its threshold."""
    up: Any = np.nan
    """Steps up that the force followed; then sums of times to 63 % and from 10 to 90 %, in periods, and squares."""
    up_63: Any = np.nan
    up_63_2: Any = np.nan
    up_90: Any = np.nan
    up_90_2: Any = np.nan
    down: Any = np.nan
    down_63: Any = np.nan
    down_63_2: Any = np.nan
    down_90: Any = np.nan
    down_90_2: Any = np.nan
    period_s: Any = np.nan
    shift: Any = 0.0
    """Constant that r and f are counted from, N."""


class Metric(NamedTuple):
    """One number per run: how to compute it, which sums it needs, its unit and meaning."""

    of: Callable[[Sums], Any]
    groups: int
    units: str
    long_name: str


def _spread(sum_: Any, squares: Any, count: Any) -> Any:
    """Return sum (x - mean x)^2, NaN where x is constant (a goodness of fit has no meaning there)."""
    spread = squares - sum_ * sum_ / count
    # What is left of the squares of a constant is their rounding.
    return np.where(spread > 1e-12 * squares, spread, np.nan)


def _covariance(s: Sums) -> Any:
    return s.fr - s.f * s.r / s.count


def _r2_identity(s: Sums) -> Any:
    return 1.0 - s.error2 / _spread(s.r, s.r2, s.count)


def _r2_regression(s: Sums) -> Any:
    return (_covariance(s) / _spread(s.r, s.r2, s.count)) * (_covariance(s) / _spread(s.f, s.f2, s.count))


def _slope(s: Sums) -> Any:
    return _covariance(s) / _spread(s.r, s.r2, s.count)


def _force_std(s: Sums) -> Any:
    return np.sqrt(np.maximum(s.f2 / s.count - (s.f / s.count) ** 2, 0.0))


def _setpoint_std(s: Sums) -> Any:
    return np.sqrt(np.maximum(s.r2 / s.count - (s.r / s.count) ** 2, 0.0))


def _mean_s(sum_: Any, count: Any, period_s: Any) -> Any:
    """Return a mean time in s, NaN where there was none."""
    return np.where(count > 0, sum_ / np.maximum(count, 1.0), np.nan) * period_s


METRICS: dict[str, Any] = {
    "r2_identity": Metric(_r2_identity, IDENTITY, "1", "goodness of fit to f_a = f_r"),
    "r2_regression": Metric(_r2_regression, REGRESSION, "1", "squared correlation of f_a on f_r"),
    "slope": Metric(_slope, REGRESSION, "1", "slope of the regression of f_a on f_r"),
    "rms_error": Metric(lambda s: np.sqrt(s.error2 / s.count), IDENTITY, "N", "rms of f_a - f_r"),
    "saturation_index": Metric(
        lambda s: s.saturated / s.count, SATURATION, "1", "share of periods with a clamped command"
    ),
    "output_noise": Metric(_force_std, REGRESSION, "N", "standard deviation of f_a"),
    "r2_bound": Metric(
        lambda s: 1.0 - s.shortfall2 / _spread(s.r, s.r2, s.count),
        BOUND,
        "1",
        "best r2_identity any controller could reach",
    ),
    "perceptual_index": Metric(
        lambda s: np.sqrt(s.felt2 / s.count), PERCEPTION, "1", "residual over its threshold, rms: felt above 1"
    ),
    "rise_63_s": Metric(lambda s: _mean_s(s.up_63, s.up, s.period_s), STEPS, "s", "mean time to 63 % of a step up"),
    "rise_10_90_s": Metric(lambda s: _mean_s(s.up_90, s.up, s.period_s), STEPS, "s", "mean time from 10 to 90 % up"),
    "fall_63_s": Metric(
        lambda s: _mean_s(s.down_63, s.down, s.period_s), STEPS, "s", "mean time to 63 % of a step down"
    ),
    "fall_10_90_s": Metric(
        lambda s: _mean_s(s.down_90, s.down, s.period_s), STEPS, "s", "mean time from 10 to 90 % of a step down"
    ),
    "mean_force": Metric(lambda s: s.shift + s.f / s.count, REGRESSION, "N", "mean of f_a"),
    "mean_setpoint": Metric(lambda s: s.shift + s.r / s.count, IDENTITY, "N", "mean of f_r"),
    "setpoint_spread": Metric(_setpoint_std, IDENTITY, "N", "standard deviation of f_r"),
    "scored_periods": Metric(lambda s: s.count, IDENTITY, "1", "control periods that count"),
}
"""Every metric by name; those that are registered from outside too (loop/metric)."""
DEFAULT_METRICS = ("r2_identity", "rms_error", "saturation_index")
