"""Scales of the channels that measure touch: load cells and position."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from scipy.constants import g as STANDARD_GRAVITY

from frictionloop.identification.calibration import weights
from frictionloop.identification.channels import READING_UNITS, channel
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.measured import measured
from frictionloop.identification.straight_scale import straight_scale
from frictionloop.identification.takes.plate import Found, _line_drawn
from frictionloop.quantities import FrictionloopError

GRAVITY = 0.0015
"""Relative error of the standard gravity for that of an unknown place: 9.780 to 9.832 m/s^2, over sqrt(3)."""


def load(take: Any, runs: Sequence[xr.Dataset], sensor: Any, date: str) -> Found:
    """Return the scale of the load cells from weights put on the plate, and what of a load the force sensor reads."""
    gravity = take.gravity_m_s2 or STANDARD_GRAVITY
    lines = [weights(_as_reading(run), take.settle_s, gravity, take.tolerance) for run in runs]
    unit = lines[0].steps.unit
    slopes = [max(line.sensitivity, line.left_out, key=lambda each: each.standard_error) for line in lines]
    share = 0.0 if take.gravity_m_s2 else GRAVITY
    methods = [float(np.hypot(line.weights_error, share)) * abs(line.sensitivity.value) for line in lines]
    how = f"line through {sum(line.steps.mass_kg.size for line in lines)} weights on the plate"
    values = [
        measured("load_sensitivity", slopes, methods, how, take.files, date),
        measured("load_offset", [line.offset for line in lines], [0.0] * len(lines), how, take.files, date),
    ]
    told = [f"R2 = {line.r2:.6f}, residual {1e3 * line.residual_rms_n:.2g} mN rms" for line in lines]
    if all("f_m" in run for run in runs):
        crossed = [_crosstalk(weights(run, take.settle_s, gravity), sensor.sensitivity) for run in runs]
        values.append(measured("crosstalk", crossed, [0.0] * len(crossed), how, take.files, date))
        told.append(f"of each newton of load {values[-1].value:+.2g} N show as friction")
    curves: dict[str, Any] = {
        "unit": unit,
        "force_n": [(line.steps.mass_kg * gravity).tolist() for line in lines],
        "reading": [line.steps.reading.tolist() for line in lines],
        "residual_n": [line.residuals_n.tolist() for line in lines],
        "slope": values[0].value,
        "offset": values[1].value,
        "overrides": _board("load_n_per_count", values[0].value, "load_zero_counts", values[1].value, unit),
    }
    rows: list[tuple[str, ...]] = [("mass (g)", f"reading ({unit})", "residual (mN)")]
    for line in lines:
        parts = zip(line.steps.mass_kg, line.steps.reading, line.residuals_n, strict=True)
        rows += [(f"{1e3 * m:.4g}", f"{y:.6g}", f"{1e3 * r:+.3g}") for m, y, r in parts]
    return values, told, rows, curves


def _as_reading(run: xr.Dataset) -> xr.Dataset:
    if "load" not in run:
        raise FrictionloopError("recording has no column 'load'; accepted: 'mass' and 'load', weights put on the plate")
    return run.drop_vars("f_m", errors="ignore").rename(load="f_m")


def _crosstalk(line: Any, sensitivity: float) -> Estimate:
    """Return the force read per load, N/N."""
    found = line.sensitivity
    return Estimate(found.value / sensitivity, found.standard_error / abs(sensitivity), "N/N", found.freedom)


def _board(scale: str, slope: float, zero: str, offset: float, unit: str) -> dict[str, Any]:
    """Return what a device's board is told, where readings are counts."""
    return {f"board.{scale}": 1 / slope, f"board.{zero}": round(offset)} if unit == "counts" else {}


def position(take: Any, runs: Sequence[xr.Dataset], sensor: Any, date: str) -> Found:
    """Return the scale of the position sensor from known ways: ``position`` in m and ``reading``."""
    found, unit = [], ""
    for run in runs:
        dim = "row" if "row" in run.dims else "time"
        known = channel(run, "position", ("m",), dim=dim)
        reading = channel(run, "reading", (*READING_UNITS, "m", ""), dim=dim)
        unit = str(run["reading"].attrs["units"])
        found.append(straight_scale(reading, known, f"m/{unit or 'reading'}"))
    how = f"line through {sum(line.x.size for line in found)} places"
    slopes, methods = [line.slope for line in found], [line.method for line in found]
    value = measured("position_scale", slopes, methods, how, take.files, date)
    told = [f"R2 = {line.r2:.6f}, residual {1e6 * line.residual:.2g} um rms" for line in found]
    rows: list[tuple[str, ...]] = [("reading", "position (mm)")]
    rows += [(f"{x:.6g}", f"{1e3 * y:.4g}") for line in found for x, y in zip(line.x[:200], line.y[:200], strict=True)]
    overrides = {"board.position_m_per_count": value.value} if unit == "counts" else {}
    drawn = _line_drawn(found[0], f"reading ({unit})", "position (m)")
    return [value], told, rows, {"pairs": drawn, "overrides": overrides}
