"""The numbers of Fig. 5a: gains, how stable they are, and how the force follows, by controller."""

from __future__ import annotations

from collections.abc import Iterable

import xarray as xr

from frictionloop.analysis.linear import check_pi
from frictionloop.parameters import System
from frictionloop.report import protocol
from frictionloop.report.claims.claim import Value
from frictionloop.report.device import CONTROLLERS, OPEN, fit
from frictionloop.report.people import the_finger
from frictionloop.report.results import Results
from frictionloop.report.stability import Stability, stability

Row = dict[str, Value]
Table = dict[str, Row]


def strokes(names: Iterable[str], results: Results) -> Table:
    """Return gains, where they are stable, R2, slope, spread about the regression and error, by controller."""
    base = protocol.finger_system(the_finger())
    return {name: _gains(name, base.evolve(CONTROLLERS[name])) | _fit(results.tracked[name]) for name in names}


def _gains(name: str, system: System) -> Row:
    if name == OPEN:
        return {"kp": None, "ki": None, **dict.fromkeys(Stability._fields)}
    controller = check_pi(system)
    return {"kp": controller.kp, "ki": controller.ki, **stability(system)._asdict()}


def _fit(runs: xr.Dataset) -> Row:
    found = fit(runs)
    return {
        "r2_regression": found.regression,
        "r2_identity": found.identity,
        "slope": found.slope,
        "spread_n": found.spread_n,
        "error_n": found.rms_n,
    }
