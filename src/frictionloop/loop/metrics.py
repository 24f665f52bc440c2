"""How good a run is: the metrics of a run's traces (loop/formulas.py has the formulas, which sweeps share)."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np
import xarray as xr

from frictionloop.loop import formulas
from frictionloop.loop.record import described, system_of
from frictionloop.physics.reach import Reach, reach
from frictionloop.quantities import FrictionloopError

METRICS = formulas.METRICS
"""Every metric by name."""


def kept(run: xr.Dataset, mask: Any) -> Any:
    """Return what picks the scored periods out of a trace."""
    if not isinstance(run, xr.Dataset) or "time" not in run.dims:
        raise no_run(run)
    if mask is None and "scored" not in run:
        return slice(None)
    mask = run["scored"].values if mask is None else mask
    keep = np.asarray(mask, dtype=bool)
    if keep.shape != run["time"].shape:
        raise FrictionloopError(f"mask: shape {keep.shape}; must be {run['time'].shape}")
    if not keep.any():
        raise FrictionloopError("mask: keeps no control period to score")
    return keep


def no_run(run: Any) -> FrictionloopError:
    """Return the error of what is no run."""
    return FrictionloopError(f"run: {type(run).__name__} is no run of fl.simulate")


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
    if not isinstance(run, xr.Dataset) or "time" not in run.dims:
        raise no_run(run)
    late = run["time"].values >= from_s
    scored = late & run["scored"].values if "scored" in run else late
    return run.assign(scored=xr.Variable("time", scored, described("scored"), fastpath=True))  # else xarray loads dask


def _value(name: str, run: xr.Dataset, mask: Any) -> float:
    """Return a metric, its tally summed over the traces."""
    metric, keep = METRICS[name], kept(run, mask)
    r, f = run["f_r"].values[keep], run["f_a"].values[keep]
    shift = r[0]
    sums = {"shift": shift, "error2": np.sum((f - r) ** 2), "saturated": np.sum(run["saturated"].values[keep])}
    if metric.tally is formulas.SHORTFALL:
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
    """Add to what a metric is what all take and refuse."""
    metric.__doc__ = f"""{inspect.getdoc(metric)}

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
    keep, slope = kept(run, mask), _value("slope", run, mask)
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
