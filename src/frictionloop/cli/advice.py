"""Does the loop ring? Which runs, recordings and populations look so, and are asked of the linear analysis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.cli.ringing import Ringing, of_system
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

CLAMPED, MISSING = 0.05, 0.1
"""A run is looked at if more commands than this are clamped, or R2 is further than this below its bound (chosen).

A bound that is itself this far below 1 explains clamped commands.
"""
SIGNS = ("saturation_index", "r2_identity")
"""Metrics in which ringing shows."""
FAR = 0.5
"""A population is looked at if its median R2 is further than this below its bound (chosen), as not all reach it."""


def ringing(run: xr.Dataset, mask: np.ndarray, metrics: dict[str, float]) -> Ringing | None:
    """Return what is known of a run that rings, None for one that shows no sign of it or is stable."""
    if not mask.any():
        return None
    from frictionloop.analysis.levels import RECORDED, at_levels
    from frictionloop.loop.record import system_of
    from frictionloop.loop.run_ringing import loudest_hz

    system, bound = system_of(run), metrics["r2_bound"]
    recorded = "d" in run and system.disturbance.kind in RECORDED
    # A set-point out of reach clamps by itself. Of a constant one R2 is NaN: any such run is looked at.
    quiet = metrics["saturation_index"] <= CLAMPED or (bound < 1.0 - MISSING and not recorded)
    calm = quiet and bound - metrics["r2_identity"] <= MISSING
    if calm:
        return None
    try:
        found = of_system(at_levels(system, run, mask))
    except FrictionloopError:  # a recording beyond the sensor's range has no levels
        return None
    if found is None or found.frequency_hz is None:
        return found
    return found._replace(frequency_hz=loudest_hz(run, mask, found.frequency_hz))


def of_recording(run: xr.Dataset, mask: np.ndarray) -> dict[str, float]:
    """Return the metrics that `ringing` asks of a device's recording; by the measured force where no other is known.

    What a controller could reach is not known of a real finger: the bound is taken as 1, so more runs are looked at.
    """
    import frictionloop as fl

    if not mask.any():
        return {"r2_identity": math.nan, "r2_bound": math.nan, "saturation_index": math.nan}
    known = run if "f_a" in run else run.assign(f_a=run["f_m"])
    found = {name: getattr(fl, name)(known, mask) for name in SIGNS}
    return found | {"r2_bound": 1.0}


def of_population(system: System, median_r2: float, duration_s: float) -> Ringing | None:
    """Return what the linear analysis says of the system of a population that follows badly, None if it holds."""
    if not median_r2 < 1.0 - FAR:  # also NaN; no bound is above 1
        return None
    from frictionloop.analysis.levels import at_levels
    from frictionloop.loop.sweep import sweep

    bound = sweep(system, [{}], duration_s, metrics=["r2_bound"], n_jobs=1, progress=False)["r2_bound"].values.item()
    try:
        found = of_system(at_levels(system)) if bound - median_r2 > FAR else None
    except FrictionloopError:  # a recorded set-point beyond the sensor's range, of which the reach is told
        return None
    # What is clamped rings lower than the pole it grew from, and no run of a finger is kept that shows how low.
    return found if found is None or found.stable else found._replace(frequency_hz=None)
