"""What a comparison scores: both kinds of R2 over several runs together, step times, and what touch feels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.design.comparison import trial_protocol
from frictionloop.design.comparison.comparison_run import PLAIN, LawRuns
from frictionloop.design.comparison.trial_protocol import LEVELS_N

Array = np.ndarray


class Pooled(NamedTuple):
    """Fit over all runs: 1 - sum (f - r)^2 / sum (r - mean r)^2, squared correlation, and rms of f - r."""

    r2_identity: Array
    r2_regression: Array
    rms_error: Array


def pooled(
    periods: Array, rms_error: Array, mean_r: Array, mean_f: Array, std_r: Array, std_f: Array, slope: Array
) -> Pooled:
    """Return the fit over runs taken as one record; NaN where a run has no value or the pooled r is constant.

    Given are moments over the scored periods of runs, the first axis of each array, and ``slope``, that of the
    regression of f on r: covariance over variance of r.

    With m the means over everything, sum (r - m_r)^2 = sum_i n_i (s_ri^2 + (m_ri - m_r)^2), and so for f and for their
    product, in which slope_i s_ri^2 is the covariance within run i.
    """
    weight = periods / periods.sum(axis=0)
    from_r, from_f = (each - np.sum(weight * each, axis=0) for each in (mean_r, mean_f))
    variance_r = np.sum(weight * (std_r**2 + from_r**2), axis=0)
    variance_f = np.sum(weight * (std_f**2 + from_f**2), axis=0)
    covariance = np.sum(weight * (slope * std_r**2 + from_r * from_f), axis=0)
    error2 = np.sum(weight * rms_error**2, axis=0)
    spread = np.where(variance_r > 0.0, variance_r, np.nan)
    moving = np.where(variance_f > 0.0, variance_f, np.nan)
    return Pooled(1.0 - error2 / spread, covariance**2 / (spread * moving), np.sqrt(error2))


def pooled_rms(count: Array, rms: Array) -> Array:
    """Return the rms over runs together, along the first axis."""
    return np.asarray(np.sqrt(np.sum(count * rms**2, axis=0) / np.sum(count, axis=0)))


class Score(NamedTuple):
    """What a score is called for a person, its unit, and whether more of it is better."""

    long_name: str
    units: str = "1"
    larger_is_better: bool = False


SCORES: dict[str, Score] = {
    "r2_identity": Score("R2 of f_a = f_r, pooled", larger_is_better=True),
    "r2_regression": Score("R2 of the regression, pooled", larger_is_better=True),
    **{f"r2_identity_{n:g}_n": Score(f"R2 of f_a = f_r around {n:g} N", "1", True) for n in LEVELS_N},
    **{f"r2_regression_{n:g}_n": Score(f"R2 of the regression around {n:g} N", "1", True) for n in LEVELS_N},
    "worst_level_r2_identity": Score("R2, worst level", "1", True),
    "residual_rms_n": Score("rms error, sines", "N"),
    "hold_rms_n": Score("rms error, holds", "N"),
    "landing_rms_n": Score("rms error, landings", "N"),
    "turn_peak_n": Score("mean peak after turns, 0.6 N", "N"),
    "rise_63_s": Score("step up, to 63 %", "s"),
    "rise_10_90_s": Score("step up, 10 to 90 %", "s"),
    "fall_63_s": Score("step down, to 63 %", "s"),
    "fall_10_90_s": Score("step down, 10 to 90 %", "s"),
    "perceptual_index": Score("perceptual index D, sines"),
    "relative_index": Score("D over a plain stroke"),
    "saturation_index": Score("share clamped, sines"),
}
"""Every score by name. Times are NaN for a finger whose force does not follow the steps, or crosses before it can."""
_DIMS = ("law", "speed_mm_s", "slip_length_um", "finger")


def scores(comparison: LawRuns) -> xr.Dataset:
    """Return every score over law, speed_mm_s, slip_length_um and finger.

    ``capable`` (speed_mm_s, finger) says which fingers can be given 0.3 and 0.9 N at their mean load; ``resonance``
    (finger) is the true one over the bench's.

    Both times of a direction are NaN on a finger whose mean time to 63 % is within the delay of the loop: nothing acts
    so soon, so the force rings across the level and does not answer the step.
    """
    laws, speeds = list(comparison.laws), list(comparison.speeds_mm_s)
    own = comparison.cells.sel(speed_mm_s=speeds).transpose("task", *_DIMS)
    cells = own.sel(law=laws)
    stepped = cells.sel(task=trial_protocol.STEPPED)
    times = answering({name: stepped[name].values for name in trial_protocol.TIMES}, dead_times_s(comparison))
    found = _fits(cells) | _levels(cells) | times
    found["perceptual_index"] = _felt(cells)
    found["relative_index"] = found["perceptual_index"] / _felt(own.sel(law=[PLAIN]))
    variables: dict[str, Any] = {
        name: (_DIMS, found[name], {"units": score.units, "long_name": score.long_name})
        for name, score in SCORES.items()
    }
    # As long as a finger must be able to hold the forces, it is on the plate.
    some = [trial_protocol.able(comparison.system, comparison.people, v, comparison.duration_s) for v in speeds]
    variables["capable"] = (("speed_mm_s", "finger"), np.array(some))
    met = [each.get("sensor.resonance_hz", np.nan) for each in comparison.people]
    nominal = getattr(comparison.system.sensor, "resonance_hz", np.nan)
    coordinates = {name: cells[name] for name in _DIMS} | {"resonance": ("finger", np.array(met) / nominal)}
    return xr.Dataset(variables, coordinates, comparison.cells.attrs)


def dead_times_s(comparison: LawRuns) -> np.ndarray:
    """Return the time in s, by law, within which no command follows a step."""
    systems = [comparison.system.evolve(overrides) for overrides in comparison.laws.values()]
    return np.array([each.controller.delay_s for each in systems])


def answering(times: dict[str, np.ndarray], dead_s: np.ndarray) -> dict[str, np.ndarray]:
    """Return step times (s, by law first) with NaN in both of a direction where 63 % are reached within ``dead_s``."""
    found: dict[str, np.ndarray] = {}
    for way in ("rise", "fall"):
        # Means of whole periods: as long as the delay is to the last bits.
        limit = dead_s.reshape(-1, *(1,) * (times[f"{way}_63_s"].ndim - 1)) * (1.0 + 1e-9)
        early = times[f"{way}_63_s"] <= limit
        found |= {name: np.where(early, np.nan, times[name]) for name in times if name.startswith(way)}
    return found


def spread(values: np.ndarray, larger_is_better: bool) -> tuple[float, float]:
    """Return the median over fingers and the worst decile: nine fingers in ten do as well or better.

    A finger without a value, a step that was never followed, counts as the worst; infinity stands for it.
    """
    if values.size == 0 or np.isnan(values).all():
        return np.nan, np.nan
    loss = np.sort(np.where(np.isnan(values), np.inf, -values if larger_is_better else values))
    sign = -1.0 if larger_is_better else 1.0
    middle = loss[(loss.size - 1) // 2], loss[loss.size // 2]
    median = middle[0] if middle[0] == middle[1] else float(np.mean(middle))
    return float(sign * median), float(sign * loss[int(np.ceil(0.9 * loss.size - 1e-9)) - 1])


def _fits(cells: xr.Dataset) -> dict[str, np.ndarray]:
    sines = cells.sel(task=list(trial_protocol.SINES))
    names = ("scored_periods", "rms_error", "mean_setpoint", "mean_force", "setpoint_spread", "output_noise", "slope")
    fit = pooled(*(sines[name].values for name in names))
    holds = cells.sel(task=list(trial_protocol.HOLDS))
    count = sines["scored_periods"].values
    return {
        "r2_identity": fit.r2_identity,
        "r2_regression": fit.r2_regression,
        "residual_rms_n": fit.rms_error,
        "hold_rms_n": pooled_rms(holds["scored_periods"].values, holds["rms_error"].values),
        "landing_rms_n": cells["rms_error"].sel(task=trial_protocol.LANDINGS).values,
        "turn_peak_n": cells["turn_peak"].sel(task=trial_protocol.HOLDS[1]).values,
        "saturation_index": np.sum(count * sines["saturation_index"].values, axis=0) / count.sum(axis=0),
    }


def _levels(cells: xr.Dataset) -> dict[str, np.ndarray]:
    sines = cells.sel(task=list(trial_protocol.SINES))
    found = {"worst_level_r2_identity": sines["r2_identity"].values.min(axis=0)}
    for task, level in zip(trial_protocol.SINES, LEVELS_N, strict=True):
        for name in ("r2_identity", "r2_regression"):
            found[f"{name}_{level:g}_n"] = sines[name].sel(task=task).values
    return found


def _felt(cells: xr.Dataset) -> np.ndarray:
    sines = cells.sel(task=list(trial_protocol.SINES))
    return pooled_rms(sines["scored_periods"].values, sines["perceptual_index"].values)
