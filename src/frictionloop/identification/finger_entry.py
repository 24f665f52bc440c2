"""What is measured of a finger under amplitude commands: f0, tau, moisture, the law, and a table where it is needed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.measured import measured
from frictionloop.identification.monotone_table import monotone_table
from frictionloop.identification.part import Rows, Sensor, Told, in_newtons
from frictionloop.identification.project import Take
from frictionloop.identification.vibrated import UNTOLD, Vibrated, vibrated
from frictionloop.identification.vibrated_fit import FIXED, LAWS, PRIORS

POINTS = 400
TABLE = 33


def amplitude_told(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Told:
    """Return f0 and tau, and what else the recordings tell better than what is known of fingers beforehand."""
    converted = [in_newtons(run, sensor) for run in runs]
    scaled = [run for run, _ in converted]
    found = [vibrated(run, take.plate_hz) for run in scaled]
    whole = found[0] if len(found) == 1 else vibrated(scaled, take.plate_hz)
    how = f"{sum(f.log_share.size for f in found)} pieces of slides under amplitude commands, {whole.law} law"
    none = [0.0] * len(found)

    def line(path: str, each: list[Estimate], methods: list[float]) -> Any:
        return measured(path, each, methods, how, take.files, date)

    values = [
        line("friction.nominal_n", [f.nominal for f in found], [f.method_n for f in found]),
        line("friction.susceptibility_per_um2", [f.susceptibility for f in found], [f.method_per_um2 for f in found]),
    ]
    more = {"load_exponent": "load", "occlusion_ratio": "occlusion", "moist_loss": "loss"}
    for name, prior in more.items():
        each = [getattr(f, name) for f in found]
        value = line(f"friction.{name}", [one._replace(value=max(one.value, 0.0)) for one in each], none)
        # What the recordings do not tell is what was known before, and stays assumed.
        if value.error < 0.5 * PRIORS[prior][1]:
            values.append(value)
    curves: dict[str, Any] = {"law": _drawn(whole), "overrides": _overrides(whole)}
    if take.finger is not None:
        curves["person"] = {"finger": take.finger, "found": [_logs(f) for f in found]}
    rows: Rows = [("law", "AIC above the best", "scatter", "what it says")]
    best = whole.laws[0].aic
    rows += [(each.name, f"{each.aic - best:.1f}", f"{each.residual:.1%}", each.words) for each in whole.laws]
    numbers: dict[str, Any] = {"law": whole.law, "pieces": whole.pieces}
    numbers |= {f"aic_above_the_best_{each.name}": each.aic - best for each in whole.laws}
    numbers["scatter_percent"] = 100 * whole.laws[0].residual
    doubts = [each for _, some in converted for each in some]
    return Told(values, [*doubts, *whole.findings], numbers, rows, curves)


def _overrides(found: Vibrated) -> dict[str, Any]:
    """Return the law and the table where the law is told and is not the Gaussian, which needs no table."""
    if found.law in ("gaussian", UNTOLD):
        return {}
    kind = {"friction.kind": "rough_contact"} if found.law == "exponential" else {}
    return kind | monotone_table(found, TABLE).overrides()


def _logs(found: Vibrated) -> dict[str, Any]:
    """Return logarithms of f0 and tau with their errors, those of the method among them."""
    f0, tau = found.nominal, found.susceptibility
    errors = [math.hypot(f0.standard_error, found.method_n), math.hypot(tau.standard_error, found.method_per_um2)]
    return {
        "friction.nominal_n": [math.log(f0.value), errors[0] / f0.value],
        "friction.susceptibility_per_um2": [math.log(tau.value), errors[1] / tau.value],
    }


def _drawn(found: Vibrated) -> dict[str, Any]:
    step = max(found.amplitude_um.size // POINTS, 1)
    fine = np.linspace(0.0, found.largest_um, 60)
    laws, level = {law.name: law for law in LAWS}, math.log(found.nominal.value)
    # Each law has an f0 of its own, and what is drawn is the share of the f0 that is told.
    curves = {
        fit.name: np.exp(
            fit.x[0] - level - laws[fit.name].exponent(fine, np.array(fit.x[FIXED:]), found.largest_um)
        ).tolist()
        for fit in found.laws
    }
    share = np.exp(found.log_share[::step])
    return {
        "amplitude_um": found.amplitude_um[::step].tolist(),
        "share": share.tolist(),
        "fine_um": fine.tolist(),
        "laws": curves,
    }
