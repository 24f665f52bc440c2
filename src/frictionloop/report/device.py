"""The protocol of Section 4.2 run on the bench under each controller: tracking, steps, and a population."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.loop.workers import Job, simulate_all
from frictionloop.parameters import RETUNED, System
from frictionloop.report import protocol

OPEN, PRINTED, RETUNED_GAINS, IDEAL = "open loop", "printed gains", "re-tuned gains", "ideal sensor, no delay"
CONTROLLERS: dict[str, Mapping[str, Any]] = {
    OPEN: {"controller.kind": "lookup"},
    PRINTED: {},
    RETUNED_GAINS: RETUNED,
    IDEAL: {"sensor.kind": "lowpass", "controller.delay_s": 0.0},
}
"""What commands the plate. The last is a control: the printed gains, the sensor of Section 2, no computing delay."""
CLOSED = (PRINTED, RETUNED_GAINS, IDEAL)
KEPT = ("f_r", "f_a", "a", "saturated", "scored")


def run_all(jobs: Iterable[Job]) -> list[xr.Dataset]:
    """Return the scored part of the stroke of every (system, seed)."""
    runs = simulate_all(jobs, protocol.STROKE_S, KEPT, protocol.START_S)
    return [run.assign_coords(time=run["time"] - protocol.START_S) for run in runs]


def tracking(system: System, overrides: Mapping[str, Any]) -> xr.Dataset:
    """Return f_r, f_a (N), a (um) and saturated over ``level``, ``stroke`` and ``time`` for a bench with a finger."""
    strokes, sines = protocol.strokes(system.evolve(overrides)), protocol.THE_SINES
    jobs = [
        (stroke.evolve({"setpoint": sines.at(level_n)}), protocol.seed_of(i, j))
        for i, level_n in enumerate(sines.levels_n)
        for j, stroke in enumerate(strokes)
    ]
    runs, n = run_all(jobs), len(strokes)
    levels = [xr.concat(runs[n * i : n * (i + 1)], "stroke") for i in range(len(sines.levels_n))]
    return xr.concat(levels, "level").assign_coords(level=list(sines.levels_n))


def stepping(system: System, overrides: Mapping[str, Any]) -> xr.Dataset:
    """Return the same over ``stroke`` and ``time`` for a set-point that steps."""
    strokes = protocol.strokes(system.evolve({**overrides, "setpoint": protocol.steps()}))
    return xr.concat(run_all((stroke, protocol.seed_of(0, j)) for j, stroke in enumerate(strokes)), "stroke")


class Fit(NamedTuple):
    """Goodness of fit to f_a = f_r, of a regression of f_a on f_r, its slope, and the rms of f_a - f_r in N."""

    identity: float
    regression: float
    slope: float
    rms_n: float
    spread_n: float
    """Standard deviation of f_a about its regression on f_r, N."""


def fit(runs: xr.Dataset) -> Fit:
    """Return both kinds of R2 over all that counts in a Dataset (as in loop/metrics, for several runs together)."""
    r, f = (runs[name].values[runs["scored"].values] for name in ("f_r", "f_a"))
    error2, spread = np.mean((f - r) ** 2), r.var()
    covariance = np.mean((r - r.mean()) * (f - f.mean()))
    regression = float(covariance**2 / (spread * f.var()))
    return Fit(
        float(1.0 - error2 / spread),
        regression,
        float(covariance / spread),
        float(np.sqrt(error2)),
        float(np.sqrt((1.0 - regression) * f.var())),
    )
