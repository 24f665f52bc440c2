"""A run beside others of its system, loop open, disturbance steady, plain stroke; what is felt, and every metric."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop import metrics as plain
from frictionloop.loop.metric import RunMetric, fade_gain, faded_and_filtered
from frictionloop.loop.metrics import check_run, counted, of_a_run
from frictionloop.loop.record import system_of
from frictionloop.loop.simulate import is_finite, simulate, traced
from frictionloop.loop.transients import reversal_metrics
from frictionloop.parameters import Constant, Recording, Strokes, System
from frictionloop.perception.weighting import weighting_sos
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.units import SignalWarning

OPENED = {"controller.kind": "lookup"}
"""What opens a loop: the lookup table alone turns the set-point into an amplitude (paper, Sec. 2.2)."""
OPEN_ERROR = "open_loop_rms_error"
"""Name of the rms error in open loop beside that of the loop."""
LEAST_N = 1e-5
"""A variation (rms) below this is nothing to judge a loop by: a thousandth of that of a finger (assumed)."""


def open_loop_of(run: xr.Dataset) -> xr.Dataset | None:
    """Return the run of the same system, seed and duration under the lookup table alone.

    None for what was measured on a device, whose disturbance does not come again.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``.

    Raises
    ------
    FrictionloopError
        For a run without its System.
    """
    return _again(run, OPENED)


@of_a_run
def disturbance_left(run: xr.Dataset, mask: Any = None) -> float:
    """Return how much of the disturbance's variation is left in the force, by the same run with its mean alone.

        rms(f_a - f_a with d = mean(d)) / rms(d - mean(d))

    Both runs have the same finger, set-point and noise, so errors that are there anyway do not count. 0: all is
    cancelled; 1: none, as in open loop; above 1: the loop makes it worse, as one that rings does. NaN for a
    disturbance that is constant or varies by less than 0.01 mN rms, and for what was measured on a device, whose
    finger does not come again.
    """
    if "d" not in run:
        return math.nan
    keep = counted(run, mask)
    calm = steady_of(run, mask)
    varies_n = float(np.std(run["d"].values[keep]))
    return math.nan if calm is None else _rms((run["f_a"].values - calm["f_a"].values)[keep]) / varies_n


def steady_of(run: xr.Dataset, mask: Any = None) -> xr.Dataset | None:
    """Return the run of the same system, seed and duration with the mean of what is scored as disturbance.

    None for a constant disturbance, and for what was measured on a device.

    Raises
    ------
    FrictionloopError
        For a run without its System.
    """
    scored = run["d"].values[counted(run, mask)]
    steady = {"disturbance": Constant(offset_n=float(scored.mean()))}
    return _again(run, steady) if float(np.std(scored)) > LEAST_N else None


SMOOTH = {
    "friction": {"roughness_rms": 0.0},
    "motion": {"tremor_um": 0.0, "tremor_n": 0.0, "load_drift": 0.0, "contact_s": 0.0},
    "sensor": {"noise_density_n_rthz": 0.0},
}
"""What makes a finger smooth, never lifted, and a sensor silent, so that only the loop can make the force swing."""


SWING_S, STROKE_S = 10.0, 1.0
"""Of a run that is looked at for a swing, and the shortest of its strokes."""


def swing_n(system: System, force_n: float) -> float:
    """Return how far the force swings by itself: peak to peak, N, about a line over the second half of a stroke.

    The finger is smooth and is asked for one force, in strokes of a second, so that a stable loop comes to
    rest. The median of the strokes.
    """
    from scipy.signal import detrend

    changes: dict[str, Any] = {"setpoint": Constant(offset_n=force_n), "disturbance": Constant()}
    for block, each in SMOOTH.items():
        changes |= {f"{block}.{name}": value for name, value in each.items() if hasattr(getattr(system, block), name)}
    if isinstance(system.motion, Strokes):
        longer = min(STROKE_S * system.motion.speed_mm_s, system.touch.load.length_mm)
        changes["motion.stroke_mm"] = max(system.motion.stroke_mm, longer)
    run = simulate(system.evolve(changes), SWING_S)
    force, mask = run["f_a"].values, run["scored"].values if "scored" in run else np.ones(run.sizes["time"], bool)
    ends = np.flatnonzero(np.diff(np.concatenate([[0], mask, [0]]))).reshape(-1, 2)
    swings = [np.ptp(detrend(force[(begin + end) // 2 : end])) for begin, end in ends if end - begin > 2]
    return float(np.median(swings))


def _again(run: xr.Dataset, changes: dict[str, Any]) -> xr.Dataset | None:
    """Return the run of the same seed and duration with changes of its System; None for one of a device."""
    system = system_of(run)
    if run.attrs.get("source") != "simulated" or "seed" not in run.attrs:
        return None
    duration_s = run.sizes["time"] / system.controller.rate_hz
    (found,) = traced([system.evolve(changes)], [int(run.attrs["seed"])], duration_s)
    return found


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


LEAST_PLAIN = 1e-6
"""Index of a plain stroke below which it varies by rounding alone (assumed)."""


@of_a_run
def perceptual_index(run: xr.Dataset, mask: Any = None) -> float:
    """Return the index D of the residual f_a - f_r, its rms in units of the threshold of touch: felt above 1.

    D = sqrt(int S(f)/F_th(f)^2 df) from 1 to 500 Hz, by the filter of `perception.weighting`. Thresholds are good to
    6 dB, and a plain stroke is felt by itself, so controllers are compared by `relative_index`. Where nothing is scored
    the residual is faded out. Refused for a control rate that the filter is not made for.
    """
    return _index(run["f_a"].values - run["f_r"].values, run, mask)


def _index(residual: np.ndarray, run: xr.Dataset, mask: Any) -> float:
    felt, scored = felt_trace(residual, run, mask)
    return float(np.sqrt(np.sum(felt**2) / np.sum(scored)))


def felt_trace(residual: np.ndarray, run: xr.Dataset, mask: Any = None) -> tuple[np.ndarray, np.ndarray]:
    """Return a force in units of the threshold of touch, 0 where nothing is scored, and 1 where it is; as of a run."""
    scored = np.ones(residual.size)
    if mask is not None or "scored" in run:
        scored = np.zeros(residual.size)
        scored[counted(run, mask)] = 1.0
    return weighted(residual, scored, system_of(run).controller.rate_hz), scored


def weighted(residual: np.ndarray, scored: np.ndarray, rate_hz: float) -> np.ndarray:
    """Return a force in units of the threshold of touch, faded out and 0 where ``scored`` is 0, not 1.

    Parameters
    ----------
    residual : array, shape (ticks,)
        Force in N.
    scored : array, shape (ticks,)
        1.0 where it counts, else 0.0.
    rate_hz : float
        Ticks per second, 1200 to 200 000.
    """
    felt = np.empty(residual.size)
    faded_and_filtered(fade_gain(rate_hz), weighting_sos(rate_hz), residual, scored, felt)
    return felt


def plain_stroke(system: System, amplitude_um: float = 0.0, duration_s: float = 10.0, seed: int = 0) -> xr.Dataset:
    """Return a run without control: the same finger, path, disturbance and seed under a constant amplitude.

    Parameters
    ----------
    system : System
        Its plant and its disturbance; set-point and gains are not used.
    amplitude_um : float
        Amplitude in um, limited to [0, a_max].
    duration_s, seed
        As in ``simulate``.

    Raises
    ------
    FrictionloopError
        For an amplitude that is not finite, or as ``simulate``.
    """
    if not is_finite(amplitude_um):
        raise must_be("amplitude_um", amplitude_um, "a finite number", "um")
    (run,) = traced([system], [seed], duration_s, amplitude_um)
    return run


def plain_like(run: xr.Dataset) -> xr.Dataset:
    """Return the plain stroke of a run's finger, path and seed whose mean force is that of the run.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``; its ``scored`` periods give the mean.

    Raises
    ------
    FrictionloopError
        For a run without its System, or a mean force that no constant amplitude gives.
    """
    system, seed, keep = system_of(run), int(run.attrs["seed"]), counted(run, None)
    duration_s, wanted = run["time"].size / system.controller.rate_hz, float(run["f_a"].values[keep].mean())

    def at(square_um2: float) -> tuple[float, float, xr.Dataset]:
        plain = plain_stroke(system, square_um2**0.5, duration_s, seed)
        return square_um2, float(plain["f_a"].values[keep].mean()), plain

    ends = at(0.0), at(system.plate.max_amplitude_um**2)
    if not ends[0][1] >= wanted >= ends[1][1]:
        raise FrictionloopError(
            f"mean force = {wanted:.3g} N: plain strokes have {ends[1][1]:.3g} to {ends[0][1]:.3g} N", "FORCE-REACH"
        )
    return _between(at, wanted, *ends)


Tried = tuple[float, float, xr.Dataset]
"""Square of an amplitude in um^2, mean force in N, and the run."""
CLOSE_N = 1e-5
"""Mean force to which a plain stroke is found (chosen)."""
ROUNDS = 60
"""As many as halving takes at most."""


def _between(at: Callable[[float], Tried], wanted_n: float, low: Tried, high: Tried) -> xr.Dataset:
    """Return the run of a mean force between two, by regula falsi (Illinois): log F falls nearly straight with a^2."""

    def excess(tried: Tried) -> float:
        ends = (tried[1], wanted_n)
        return math.log(tried[1] / wanted_n) if min(ends) > 0.0 else tried[1] - wanted_n

    left, right, new, side = excess(low), excess(high), low, 0
    for _ in range(ROUNDS):
        if left == right:
            break
        new = at(low[0] + left / (left - right) * (high[0] - low[0]))
        if abs(new[1] - wanted_n) <= CLOSE_N:
            break
        if (found := excess(new)) > 0.0:
            low, left, right, side = new, found, right / (2.0 if side > 0 else 1.0), 1
        else:
            high, right, left, side = new, found, left / (2.0 if side < 0 else 1.0), -1
    return new[2]


@of_a_run
def relative_index(run: xr.Dataset, mask: Any = None) -> float:
    """Return D of a run over D of its plain stroke (``plain_like``), whose force is detrended stroke by stroke.

    Below 1 control makes sliding smoother than it is by itself; above 1 it adds what is felt. Refused where
    ``perceptual_index`` or ``plain_like`` is, and for a finger whose plain stroke varies by nothing.
    """
    plain = plain_like(run)
    force, keep = plain["f_a"].values, np.zeros(plain["time"].size, dtype=bool)
    keep[counted(plain, mask)] = True
    edges = np.flatnonzero(np.diff(keep.astype(int))) + 1
    residual = np.zeros(force.size)
    for part in np.split(np.arange(force.size), edges):
        if keep[part[0]] and part.size > 1:
            line = np.polynomial.Polynomial.fit(part, force[part], 1)
            residual[part] = force[part] - line(part)
    of_plain = _index(residual, plain, mask)
    if of_plain < LEAST_PLAIN:
        raise FrictionloopError("the plain stroke varies by nothing")
    return perceptual_index(run, mask) / of_plain


PLAIN = ("r2_identity", "r2_bound", "rms_error", "output_noise", "saturation_index")
REGRESSION = ("r2_regression", "slope", "intercept")
FELT = ("perceptual_index", "relative_index")
TURNS = ("rms_error_turns", "turn_peak", "feedback_share")


def metrics(run: xr.Dataset, mask: Any = None) -> dict[str, float]:
    """Return every metric of a run by name, NaN where one has no meaning (R2 of a constant set-point).

    ``disturbance_left`` compares with the same run under the disturbance's mean. ``slope`` and
    ``intercept`` (N) belong to r2_regression. Metrics of runs that are registered come last.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``.
    mask : array of bool, optional
        The control periods to score, shape (time,); all that are ``scored`` if not given.

    Raises
    ------
    FrictionloopError
        For what is no run, a mask of another shape or that keeps nothing, or a run without its System.

    Warns
    -----
    SignalWarning
        Where a metric that simulates the run again is NaN, as the recording that it read is not there.
    """
    check_run(run)
    keep = mask if mask is not None else run["scored"].values if "scored" in run else np.ones(run.sizes["time"], bool)
    # What is felt of a finger that is none says little, and costs half a second of imports.
    felt = system_of(run).motion.kind == "strokes"
    own = {name: each.of for name, each in plain.METRICS.items() if isinstance(each, RunMetric)}
    return {
        **{name: float(getattr(plain, name)(run, keep)) for name in PLAIN},
        "disturbance_left": _or_nan(disturbance_left, run, keep),
        **dict(zip(REGRESSION, plain.regression(run, keep), strict=True)),
        **reversal_metrics(run, np.asarray(keep, bool)),
        "perceptual_index": _or_nan(perceptual_index, run, keep) if felt else math.nan,
        "relative_index": _or_nan(relative_index, run, keep) if felt else math.nan,
        **{name: float(of(run.isel(time=np.asarray(keep, bool)))) for name, of in own.items()},
    }


def _or_nan(metric: Any, run: xr.Dataset, mask: np.ndarray) -> float:
    try:
        return float(metric(run, mask))
    except FrictionloopError as error:  # a control rate without a filter; a mean force that no constant amplitude gives
        system = system_of(run)
        read = [each.path for each in (system.setpoint, system.disturbance) if isinstance(each, Recording)]
        if not all(Path(path).is_file() for path in read):
            warnings.warn(f"{metric.__name__} is NaN, it simulates the run again: {error}", SignalWarning, stacklevel=3)
        return math.nan
