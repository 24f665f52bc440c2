"""What is measured of a finger: friction of its slides; f0, tau, moisture and the law under amplitude commands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.identification.measured import Estimate, measured
from frictionloop.identification.part import Rows, Sensor, Told, in_newtons
from frictionloop.identification.project import Take
from frictionloop.identification.slides import friction
from frictionloop.identification.vibrated import UNTOLD, Vibrated, monotone_table, vibrated
from frictionloop.identification.vibrated_fit import FIXED, LAWS, PRIORS

REFERENCE_LOAD_N = 0.5
"""Load at which the preset's friction law has its f0 (``friction.reference_load_n``)."""
POINTS = 400
TABLE = 33


def slides_told(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Told:
    """Return f0 at the load of the preset's law, from slides without vibration."""
    scaled = [in_newtons(run, sensor) for run in runs]
    found = [friction(run) for run, _ in scaled]
    levels = []
    for each in found:
        level = each.level_n(REFERENCE_LOAD_N)
        share = each.mu.standard_error / each.mu.value
        levels.append(Estimate(level, share * level, "N", each.mu.freedom))
    loads = [slide.load_n for each in found for slide in each.slides]
    spread = 0.2 if not np.isfinite(found[0].exponent.value) else found[0].exponent.standard_error
    off = [abs(float(spread * np.log(REFERENCE_LOAD_N / np.mean(loads)))) * level.value for level in levels]
    how = f"{len(loads)} slide{'s' * (len(loads) > 1)}, at a load of {REFERENCE_LOAD_N:g} N"
    value = measured("friction.nominal_n", levels, off, how, take.files, date)
    rows: Rows = [("from (s)", "to (s)", "speed (mm/s)", "load (N)", "friction (N)", "mu", "spectrum, two ways")]
    for s in (slide for each in found for slide in each.slides):
        row = (f"{s.start_s:.2f}", f"{s.stop_s:.2f}", f"{1e3 * s.speed_m_s:.1f}", f"{s.load_n:.3f}")
        rows.append((*row, f"{s.friction_n:.3f}", f"{s.mu:.3f}", f"{s.slope_welch:.2f}, {s.slope_whittle:.2f}"))
    slides = found[0].slides
    curves: dict[str, Any] = {
        "slides": {
            "start_s": [slide.start_s for slide in slides],
            "load_n": [slide.load_n for slide in slides],
            "friction_n": [slide.friction_n for slide in slides],
            "ratio": [slide.mu for slide in slides],
            "mu": found[0].mu.value,
        }
    }
    if take.finger is not None:
        entries = [{"friction.nominal_n": [float(np.log(e.value)), e.standard_error / e.value]} for e in levels]
        curves["person"] = {"finger": take.finger, "found": entries}
    every = [slide for each in found for slide in each.slides]
    numbers: dict[str, Any] = {"mu": found[0].mu, "speeds_mm_s": [1e3 * s.speed_m_s for s in every]}
    numbers |= {"slides": len(every), "seconds": sum(s.stop_s - s.start_s for s in every)}
    numbers["mu_change_percent"] = [100 * (s.mu_change - 1) for s in every]
    if len(every) == 1:
        numbers |= {"tremor_n": every[0].tremor_n, "onset_over_mean": every[0].onset}
    doubts = [each for _, some in scaled for each in some] + [each for one in found for each in one.findings]
    return Told([value], doubts, numbers, rows, curves)


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
