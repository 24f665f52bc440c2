"""Slides of a project: the friction of a finger at the load of the preset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.measured import measured
from frictionloop.identification.part import Rows, Sensor, Told, in_newtons
from frictionloop.identification.project import Take
from frictionloop.identification.slides import friction

REFERENCE_LOAD_N = 0.5
"""Load at which the preset's friction law has its f0 (``friction.reference_load_n``)."""


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
