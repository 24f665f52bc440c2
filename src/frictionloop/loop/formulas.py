"""The formulas of the metrics, from the sums over the scored periods that a run or a sweep gives.

r = f_r and f = f_a at the control periods t_k; sums are of r and f minus a constant near their mean, so that
differences of squares keep their digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from frictionloop.loop.score_tile import BOUND, IDENTITY, REGRESSION, SATURATION


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


METRICS: dict[str, Metric] = {
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
}
"""Every metric by name."""
DEFAULT_METRICS = ("r2_identity", "rms_error", "saturation_index")
