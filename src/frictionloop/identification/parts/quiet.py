"""A quiet stretch of a project: the noise of the electronics."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.identification.measured import measured
from frictionloop.identification.parts.part import Found, Rows, Sensor, in_newtons, thin, with_method
from frictionloop.identification.project import Take
from frictionloop.identification.quiet import Quiet, noise


def quiet_part(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Found:
    """Return the density of the electronics."""
    scaled = [in_newtons(run, sensor) for run in runs]

    def at(cutoff_hz: float | None) -> list[Quiet]:
        return [noise(run, _there(run, take.interval_s), 1.0, sensor.resonance_hz, cutoff_hz) for run, _ in scaled]

    found = at(sensor.cutoff_hz)
    off = at(sensor.cutoff_hz + sensor.cutoff_error_hz) if sensor.cutoff_hz else found
    shifts = [
        with_method(moved.density.value - each.density.value, each.other_density_n_rthz - each.density.value)
        for each, moved in zip(found, off, strict=True)
    ]
    first = found[0]
    (low, high), (start, stop) = first.band_hz, first.interval_s
    how = f"mean density from {low:.0f} to {high:.0f} Hz, {start:.1f} to {stop:.1f} s"
    value = measured("sensor.noise_density_n_rthz", [each.density for each in found], shifts, how, take.files, date)
    rows: Rows = [("band", "rms (N)"), *((band, f"{rms:.3g}") for band, rms in first.rms_n.items())]
    told = [line for _, lines in scaled for line in lines] + [each for one in found for each in one.told]
    if first.step_n:
        counts = value.value / first.step_n
        told.append(f"the converter's step is {first.step_n:.3g} N; the density is {counts:.3g} counts/rtHz")
    hertz, density = thin(first.spectrum.frequency_hz, first.spectrum.density)
    curves: dict[str, Any] = {"frequency_hz": hertz, "density": density, "band_hz": first.band_hz, "level": value.value}
    rms = list(first.rms_n.values())
    if rms:
        bands = [*first.rms_n]
        said = f"{bands[0].partition(' ')[0]} to {bands[-1].rpartition('to ')[2]}"
        curves["floor"] = {"rms_n": float(np.linalg.norm(rms)), "band": said}
    return [value], told, rows, curves


def _there(run: xr.Dataset, interval_s: tuple[float, float] | None) -> tuple[float, float] | None:
    """Return as much of an interval as was read of a long recording."""
    if interval_s is None or not float(run["time"][0]):
        return interval_s
    return float(run["time"][0]), min(interval_s[1], float(run["time"][-1]))
