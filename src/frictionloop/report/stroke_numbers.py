"""The numbers of Fig. 5a: gains, how stable they are, and how the force follows, by controller."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import xarray as xr

from frictionloop.analysis.linear import check_pi
from frictionloop.parameters import System
from frictionloop.report import protocol
from frictionloop.report.claims.claim import Value
from frictionloop.report.device import CONTROLLERS, OPEN, fit
from frictionloop.report.people import the_finger
from frictionloop.report.protocol import THE_SINES, Sines
from frictionloop.report.results import Results
from frictionloop.report.stability import Stability, stability

Row = dict[str, Value]
Table = dict[str, Row]


def of_strokes(
    runs: Mapping[str, xr.Dataset],
    controllers: Mapping[str, Mapping[str, Any]],
    base: System,
    sines: Sines = THE_SINES,
) -> Table:
    """Return gains, where they are stable, R2, slope, spread about the regression and error, by controller."""
    return {name: _gains(name, base.evolve(given), sines) | _fit(runs[name]) for name, given in controllers.items()}


def _gains(name: str, system: System, sines: Sines) -> dict[str, Value]:
    if name == OPEN:
        return {"kp": None, "ki": None, **dict.fromkeys(Stability._fields)}
    controller = check_pi(system)
    return {"kp": controller.kp, "ki": controller.ki, **stability(system, sines)._asdict()}


def strokes(names: Iterable[str], results: Results) -> Table:
    """Return the same of some controllers of the report, on its finger."""
    return of_strokes(
        results.tracked, {name: CONTROLLERS[name] for name in names}, protocol.finger_system(the_finger())
    )


def _fit(runs: xr.Dataset) -> dict[str, Value]:
    found, scored = fit(runs), float(runs["scored"].mean())
    return {
        **({"scored": scored} if scored < 1.0 else {}),
        "r2_regression": found.regression,
        "r2_identity": found.identity,
        "slope": found.slope,
        "spread_n": found.spread_n,
        "error_n": found.rms_n,
    }
