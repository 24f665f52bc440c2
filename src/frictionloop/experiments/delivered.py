"""What was delivered in one stroke: the level, and all that says whether it counts."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.experiments.protocol import Protocol, Stimulus
from frictionloop.experiments.timeline import Validity
from frictionloop.loop.record import system_of
from frictionloop.loop.reference_runs import perceptual_index
from frictionloop.quantities.checks import Array

DECLARED = {
    ("constant", "level_n"): "mean",
    ("grating", "offset_n"): "mean",
    ("grating", "amplitude_n"): "contrast",
    ("chirp", "amplitude_n"): "contrast",
    ("grating", "spacing_mm"): "asked",
}
"""What an effect takes as delivered of a field: the mean force; how much of its pattern arrived; or what was asked for,
where the field is of place, which the plate gives by itself. Other fields are taken as asked for."""


class Measures(NamedTuple):
    """One stroke in numbers, over the periods that are scored."""

    force_mean_n: float
    force_sd_n: float
    rms_error_n: float
    """Of the force against the set-point, N."""
    felt_index: float
    """Index D of that error: felt above 1."""
    saturated_share: float
    speed_mm_s: float
    load_n: float
    contact_share: float
    """Share of the stroke that is scored: the finger slides and is down."""
    lost_samples: int
    level: float
    """The field's value that was delivered."""


def measures(run: xr.Dataset, protocol: Protocol, asked: float) -> Measures:
    """Return one stroke in numbers; ``asked`` is the value of the effect's field that was asked for.

    Of a device the force is the measured one.
    """
    scored = run["scored"].values
    force = run[force_of(run)].values
    lost = int(np.isnan(force).sum())
    keep = scored & np.isfinite(force)
    if not keep.any():
        nan = math.nan
        return Measures(nan, nan, nan, nan, nan, nan, nan, 0.0, lost, nan)
    intended = run["f_r_intended" if "f_r_intended" in run else "f_r"].values
    f, r = force[keep], intended[keep]
    return Measures(
        float(f.mean()),
        float(f.std()),
        float(np.sqrt(np.mean((f - r) ** 2))),
        perceptual_index(run) if "f_a" in run and not lost else math.nan,
        float(run["saturated"].values[keep].mean()),
        1e3 * float(np.abs(run["speed"].values[keep]).mean()),
        float(run["load"].values[keep].mean()),
        float(keep.mean()),
        lost,
        _level(protocol.stimulus, asked, f, r),
    )


def force_of(run: xr.Dataset) -> str:
    """Return the name of the force that was delivered: that on the finger where it is known, else the measured one."""
    return "f_a" if "f_a" in run else "f_m"


def _level(stimulus: Stimulus, asked: float, force: Array, intended: Array) -> float:
    rule = stimulus.delivered
    if rule == "declared":
        rule = DECLARED.get((stimulus.effect.kind, stimulus.field), "asked")  # type: ignore[assignment]
    if rule == "mean":
        return asked + float(force.mean() - intended.mean())
    if rule == "contrast" and np.std(intended) > 1e-6:
        return asked * float(np.cov(intended, force)[0, 1] / np.var(intended, ddof=1))
    return asked


def why_invalid(found: Measures, rules: Validity) -> str:
    """Return why a stroke does not count, empty if it does."""
    if not math.isfinite(found.force_mean_n) or found.contact_share < rules.contact_share:
        return f"contact_share={found.contact_share:.2f}"
    for name, (low, high) in (("speed_mm_s", rules.speed_mm_s), ("load_n", rules.load_n)):
        if not low <= getattr(found, name) <= high:
            return f"{name}={getattr(found, name):.3g}"
    if found.saturated_share > rules.saturated_share:
        return f"saturated_share={found.saturated_share:.2f}"
    if rules.rms_error_n is not None and found.rms_error_n > rules.rms_error_n:
        return f"rms_error_n={found.rms_error_n:.3g}"
    if found.lost_samples > rules.lost_samples:
        return f"lost_samples={found.lost_samples}"
    return ""


def rate_of(run: xr.Dataset) -> float:
    """Return the samples per second of a run."""
    return float(system_of(run).controller.rate_hz)


def columns(found: Measures, interval: int) -> dict[str, Any]:
    """Return the measures of an interval, counted from 1, as columns of a row."""
    return {f"{name}_{interval}": value for name, value in found._asdict().items() if name != "level"}
