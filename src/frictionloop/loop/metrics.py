"""How good a run is: the same formulas from a run's traces or from the sums a sweep keeps instead.

r = f_r and f = f_a at the control periods t_k; sums are of r and f minus a constant near their mean, so that
differences of squares keep their digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.loop.record import system_of
from frictionloop.loop.score_tile import BOUND, IDENTITY, REGRESSION, SATURATION
from frictionloop.physics.friction import friction_force
from frictionloop.quantities import FrictionloopError


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


def _sums(run: xr.Dataset, mask: Any, bound: bool = False) -> Sums:
    keep = slice(None) if mask is None else np.asarray(mask, dtype=bool)
    r, f = run["f_r"].values[keep], run["f_a"].values[keep]
    if r.size == 0:
        raise FrictionloopError("mask: keeps no control period to score")
    shift = r[0]
    shortfall2 = np.nan
    if bound:
        d, system = run["d"].values[keep], system_of(run)
        floor = friction_force(system.plate.max_amplitude_um, system.friction)
        shortfall2 = np.sum((np.clip(r, floor + d, system.friction.nominal_n + d) - r) ** 2)
    error2 = np.sum((f - r) ** 2)
    saturated = np.sum(run["saturated"].values[keep])
    r, f = r - shift, f - shift
    return Sums(error2, r.sum(), r @ r, saturated, f.sum(), f @ f, f @ r, shortfall2, r.size)


def r2_identity(run: xr.Dataset, mask: Any = None) -> float:
    """Return R2 = 1 - sum (f_a - f_r)^2 / sum (f_r - mean f_r)^2, the fit to the ideal f_a = f_r (paper, Sec. 2.3).

    ``mask`` (bool over ``time``) chooses the periods scored. NaN for a constant set-point.
    """
    return float(_r2_identity(_sums(run, mask)))


class Regression(NamedTuple):
    """Least-squares line f_a = slope f_r + intercept and its squared correlation."""

    r2: float
    slope: float
    intercept_n: float


def regression(run: xr.Dataset, mask: Any = None) -> Regression:
    """Return the linear regression of f_a on f_r (paper, Sec. 4.2): R2, slope and intercept in N.

    It is blind to a wrong gain and offset, so R2 here is never below ``r2_identity``.
    """
    s = _sums(run, mask)
    slope = float(_slope(s))
    keep = slice(None) if mask is None else np.asarray(mask, dtype=bool)
    intercept = float(run["f_a"].values[keep].mean() - slope * run["f_r"].values[keep].mean())
    return Regression(float(_r2_regression(s)), slope, intercept)


def r2_regression(run: xr.Dataset, mask: Any = None) -> float:
    """Return the squared correlation of f_a on f_r; ``regression`` gives slope and intercept with it."""
    return regression(run, mask).r2


def rms_error(run: xr.Dataset, mask: Any = None) -> float:
    """Return the root mean square of f_a - f_r in N."""
    s = _sums(run, mask)
    return float(np.sqrt(s.error2 / s.count))


def saturation_index(run: xr.Dataset, mask: Any = None) -> float:
    """Return the share of control periods whose command was clamped, 0 to 1 (paper, Sec. 2.3)."""
    s = _sums(run, mask)
    return float(s.saturated / s.count)


def output_noise(run: xr.Dataset, mask: Any = None) -> float:
    """Return the standard deviation of f_a in N: sigma_f of equation (3) if set-point and disturbance are constant."""
    return float(_force_std(_sums(run, mask)))


def r2_bound(run: xr.Dataset, mask: Any = None) -> float:
    """Return the R2 of f_r clipped to the band [g(a_max) + d, f0 + d]: no controller of this plant can do better."""
    s = _sums(run, mask, bound=True)
    return float(1.0 - s.shortfall2 / _spread(s.r, s.r2, s.count))
