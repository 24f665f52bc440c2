"""The metrics of a run: the sums that the kernel keeps, what each metric makes of them, and the same of a run's traces.

r = f_r and f = f_a at the control periods t_k that count. Sums are of both less a constant near their mean, so that
differences of squares keep their digits.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from frictionloop.loop.metric import FELT, AgainMetric, Metric, Sample, Tally
from frictionloop.loop.record import described, system_of
from frictionloop.loop.transients import REVERSALS, STEP_TIMES
from frictionloop.physics.reach import Reach, reach
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.scalar_math import fma, step

if TYPE_CHECKING:
    import xarray as xr


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


class Products(NamedTuple):
    """f_r and f_a, their squares and their products."""

    shift: float
    r: float
    r2: float
    f: float
    f2: float
    fr: float


@step
def add_products(state: Products, sample: Sample, dt: float) -> Products:
    """Add a period."""
    shift, r_sum, r2, f_sum, f2, fr = state
    r, f = sample.f_r - shift, sample.f_a - shift
    return Products(shift, r_sum + r, fma(r, r, r2), f_sum + f, fma(f, f, f2), fma(f, r, fr))


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
REGRESSION = Tally("regression", add_products, Products, _from(Products))
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
    from frictionloop.loop.companion_runs import disturbance_left  # which runs, and so needs the metrics

    return disturbance_left(run, mask)


METRICS: dict[str, Any] = {
    "r2_identity": Metric(ERRORS, lambda s, n: 1.0 - s.error2 / _spread(s.r, s.r2, n), "1", "fit to f_a = f_r"),
    "r2_regression": Metric(REGRESSION, _r2_regression, "1", "squared correlation with f_r"),
    "slope": Metric(REGRESSION, _slope, "1", "slope of f_a on f_r"),
    "rms_error": Metric(ERRORS, lambda s, n: np.sqrt(s.error2 / n), "N", "rms of f_a - f_r"),
    "rms_error_turns": Metric(
        REVERSALS, lambda s, n: np.sqrt(_per(s.error2, s.periods)), "N", "rms error with turns, landings"
    ),
    "turn_peak": Metric(REVERSALS, lambda s, n: _per(s.peaks_n, s.turns), "N", "mean peak after a turn"),
    "feedback_share": Metric(REVERSALS, lambda s, n: _per(s.fed, s.slid), "1", "share of sliding with feedback"),
    "saturation_index": Metric(ERRORS, lambda s, n: s.saturated / n, "1", "share of commands clamped"),
    "output_noise": Metric(REGRESSION, lambda s, n: _std(s.f, s.f2, n), "N", "standard deviation of f_a"),
    "r2_bound": Metric(
        SHORTFALL,
        lambda s, n: 1.0 - s.shortfall2 / _spread(s.r, s.r2, n),
        "1",
        "best r2_identity in reach",
    ),
    "disturbance_left": AgainMetric(_left, "1", "share of the disturbance left"),
    "perceptual_index": Metric(FELT, lambda s, n: np.sqrt(s.felt2 / n), "1", "residual over threshold of touch"),
    "rise_63_s": Metric(STEP_TIMES, _mean_s("up", "to_63"), "s", "time to 63 % up"),
    "rise_10_90_s": Metric(STEP_TIMES, _mean_s("up", "from_10_to_90"), "s", "10 to 90 % up"),
    "fall_63_s": Metric(STEP_TIMES, _mean_s("down", "to_63"), "s", "time to 63 % down"),
    "fall_10_90_s": Metric(STEP_TIMES, _mean_s("down", "from_10_to_90"), "s", "10 to 90 % down"),
    "mean_force": Metric(REGRESSION, lambda s, n: s.shift + s.f / n, "N", "mean of f_a"),
    "mean_setpoint": Metric(ERRORS, lambda s, n: s.shift + s.r / n, "N", "mean of f_r"),
    "setpoint_spread": Metric(ERRORS, lambda s, n: _std(s.r, s.r2, n), "N", "standard deviation of f_r"),
    "scored_periods": Metric(ERRORS, lambda s, n: n, "1", "control periods that count"),
}
"""Every metric by name; those that are registered from outside too (loop/metric)."""
DEFAULT_METRICS = ("r2_identity", "rms_error", "saturation_index")


def check_run(run: Any) -> None:
    """Refuse what is no run."""
    if "time" not in getattr(run, "dims", ()):
        raise FrictionloopError(f"run: {type(run).__name__} is no run of fl.simulate")


def counted(run: xr.Dataset, mask: Any) -> Any:
    """Return what picks the scored periods out of a trace.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``.
    mask : array of bool, optional
        The control periods to score, shape (time,), in place of those that are ``scored``.

    Raises
    ------
    FrictionloopError
        For what is no run, and for a mask of another shape or that keeps nothing.
    """
    check_run(run)
    if mask is None and "scored" not in run:
        return slice(None)
    mask = run["scored"].values if mask is None else mask
    keep = np.asarray(mask, dtype=bool)
    if keep.shape != run["time"].shape:
        raise FrictionloopError(f"mask: shape {keep.shape}; must be {run['time'].shape}")
    if not keep.any():
        raise FrictionloopError("mask: keeps no period")
    return keep


def scored_from(run: xr.Dataset, from_s: float) -> xr.Dataset:
    """Return a run of which no control period before a time in s is ``scored``.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``.
    from_s : float
        Time in s.

    Raises
    ------
    FrictionloopError
        For what is no run.
    """
    import xarray as xr  # not above: a live page, which runs the loop too, is open half a second sooner

    check_run(run)
    late = run["time"].values >= from_s
    scored = late & run["scored"].values if "scored" in run else late
    return run.assign(scored=xr.Variable("time", scored, described("scored"), fastpath=True))  # else xarray loads dask


def _value(name: str, run: xr.Dataset, mask: Any) -> float:
    """Return a metric, its tally summed over the traces."""
    metric, keep = METRICS[name], counted(run, mask)
    r, f = run["f_r"].values[keep], run["f_a"].values[keep]
    shift = r[0]
    sums = {"shift": shift, "error2": np.sum((f - r) ** 2), "saturated": np.sum(run["saturated"].values[keep])}
    if metric.tally is SHORTFALL:
        sums["shortfall2"] = np.sum((run_reach(run, keep).nearest(r) - r) ** 2)
    r, f = r - shift, f - shift
    sums |= {"r": r.sum(), "r2": np.sum(r * r), "f": f.sum(), "f2": np.sum(f * f), "fr": np.sum(f * r)}  # BLAS spins
    return float(metric.of(metric.tally.state(*(sums[each] for each in metric.tally.state._fields)), r.size))


def run_reach(run: xr.Dataset, keep: Any, disturbance_n: Any = None) -> Reach:
    """Return the lowest and the highest force that vibration can leave, the disturbance (of the run) added."""
    d = run["d"].values[keep] if disturbance_n is None else disturbance_n
    if "limit" in run:
        return Reach(run["floor"].values[keep], run["limit"].values[keep]).plus(d)
    system = system_of(run)
    return reach(system.friction, system.motion, system.plate.max_amplitude_um).plus(d)


def out_of_reach(run: xr.Dataset, keep: Any) -> np.ndarray:
    """Return where the set-point is a force that no vibration could leave; bool, (samples,)."""
    return run_reach(run, keep).beyond(run["f_r"].values[keep])


Score = TypeVar("Score", bound=Callable[..., Any])


def of_a_run(metric: Score) -> Score:
    """Add to what a metric is what all take and refuse, as `counted` has it."""
    taken = (inspect.getdoc(counted) or "").partition("\n\n")[2]
    metric.__doc__ = f"{inspect.getdoc(metric)}\n\n{taken}\n"
    return metric


@of_a_run
def r2_identity(run: xr.Dataset, mask: Any = None) -> float:
    """Return R2 = 1 - sum (f_a - f_r)^2 / sum (f_r - mean f_r)^2, the fit to the ideal f_a = f_r (paper, Sec. 2.3).

    NaN for a constant set-point.
    """
    return _value("r2_identity", run, mask)


class Regression(NamedTuple):
    """Least-squares line f_a = slope f_r + intercept and its squared correlation."""

    r2: float
    slope: float
    intercept_n: float


@of_a_run
def regression(run: xr.Dataset, mask: Any = None) -> Regression:
    """Return the linear regression of f_a on f_r (paper, Sec. 4.2): R2, slope and intercept in N.

    It is blind to a wrong gain and offset, so R2 here is never below ``r2_identity``; NaN for a constant set-point.
    """
    keep, slope = counted(run, mask), _value("slope", run, mask)
    intercept = float(run["f_a"].values[keep].mean() - slope * run["f_r"].values[keep].mean())
    return Regression(_value("r2_regression", run, mask), slope, intercept)


@of_a_run
def r2_regression(run: xr.Dataset, mask: Any = None) -> float:
    """Return the squared correlation of f_a on f_r; ``regression`` gives slope and intercept with it."""
    return _value("r2_regression", run, mask)


@of_a_run
def rms_error(run: xr.Dataset, mask: Any = None) -> float:
    """Return the root mean square of f_a - f_r in N."""
    return _value("rms_error", run, mask)


@of_a_run
def saturation_index(run: xr.Dataset, mask: Any = None) -> float:
    """Return the share of control periods whose command was clamped, 0 to 1 (paper, Sec. 2.3)."""
    return _value("saturation_index", run, mask)


@of_a_run
def output_noise(run: xr.Dataset, mask: Any = None) -> float:
    """Return the standard deviation of f_a in N: sigma_f of equation (3) if set-point and disturbance are constant."""
    return _value("output_noise", run, mask)


@of_a_run
def r2_bound(run: xr.Dataset, mask: Any = None) -> float:
    """Return the R2 of f_r clipped to the band [g(a_max) + d, f0 + d]: no controller of this plant can do better.

    NaN for a constant set-point; refused for a run without its System.
    """
    return _value("r2_bound", run, mask)
