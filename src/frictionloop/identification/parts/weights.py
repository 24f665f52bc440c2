"""Weights of a project: sensitivity and offset of the reading."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from scipy.constants import g as STANDARD_GRAVITY
from scipy.stats import t as student

from frictionloop.identification.calibration import Calibration, weights
from frictionloop.identification.channels import READING, READING_UNITS
from frictionloop.identification.clipping import clipped_steps
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.measured import measured
from frictionloop.identification.parts.part import Found, Rows, Sensor
from frictionloop.identification.project import Take
from frictionloop.identification.straightness import SURE, straightness
from frictionloop.quantities import FrictionloopError

HIDDEN = 1.5e-4
"""Relative error that a pulley on ball bearings leaves while a swinging hook hides its friction: b = 2.5e-4 of a
friction of 0.0015 (docs/calibration), over sqrt(3)."""
GRAVITY = 0.0015
"""The same of the standard gravity for that of an unknown place: 9.780 to 9.832 m/s^2, over sqrt(3)."""


def weights_part(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor, date: str) -> Found:
    """Return sensitivity and offset; the errors that all weights share are those of the method."""
    gravity = take.gravity_m_s2 or STANDARD_GRAVITY
    lines = [weights(run, take.settle_s, gravity, take.tolerance) for run in runs]
    for line in lines:
        _refuse_clipped(line)
    straight = [straightness(line) for line in lines]
    methods = []
    for line, left in zip(lines, straight, strict=True):
        bent = abs(left.curvature.value) if left.curved else 0.0
        apart = 0.0 if left.friction is None else abs(left.friction.sensitivity.value - line.sensitivity.value)
        shares = [bent, line.weights_error, _swing(line), HIDDEN, 0.0 if take.gravity_m_s2 else GRAVITY]
        share = float(np.linalg.norm(shares))
        methods.append(float(np.hypot(share * abs(line.sensitivity.value), apart / np.sqrt(3))))
    slopes = [_safer(line) for line in lines]
    count = sum(line.steps.mass_kg.size for line in lines)
    how = f"line through {count} weights"
    offsets = [line.offset for line in lines]
    values = [
        measured("sensitivity", slopes, methods, how, take.files, date),
        measured("offset", offsets, [0.0] * len(lines), how, take.files, date),
    ]
    first = lines[0]
    rows: Rows = [("mass (g)", f"reading ({first.steps.unit})", "residual (mN)")]
    for line in lines:
        parts = zip(line.steps.mass_kg, line.steps.reading, line.residuals_n, strict=True)
        rows += [(f"{1e3 * m:.4g}", f"{y:.6g}", f"{1e3 * r:+.3g}") for m, y, r in parts]
    told = [f"R2 = {line.r2:.6f}, residual {1e3 * line.residual_rms_n:.2g} mN rms" for line in lines]
    told += [f"hysteresis {100 * line.hysteresis:.2g} % of the span" for line in lines if np.isfinite(line.hysteresis)]
    told += [each for left in straight for each in left.told]
    told += [line for run in runs for line in _crosstalk(run, take, gravity)]
    if not take.gravity_m_s2:
        told.append("gravity_m_s2 is not stated: the standard value may be off by 0.3 %, which is most of the interval")
    curves: dict[str, Any] = {
        "unit": first.steps.unit,
        "force_n": [(line.steps.mass_kg * gravity).tolist() for line in lines],
        "reading": [line.steps.reading.tolist() for line in lines],
        "residual_n": [line.residuals_n.tolist() for line in lines],
        "slope": values[0].value,
        "offset": values[1].value,
    }
    return values, told, rows, curves


def _refuse_clipped(line: Calibration) -> None:
    steps = line.steps
    at = clipped_steps(steps)
    if at.any():
        masses = ", ".join(f"{1e3 * mass:g}" for mass in np.unique(steps.mass_kg[at]))
        raise FrictionloopError(
            f"recording: 'f_m' is clipped at {float(steps.reading[at][0]):.4g} {steps.unit} under {masses} g; "
            "accepted: weights within the range of sensor and converter"
        )


def _swing(line: Calibration) -> float:
    """Return the relative error that hooks which still swing leave in the sensitivity.

    A swing of phi changes the tension by (phi^2/4)(1 - 3 cos 2wt): what does not average out is 0.47 of the standard
    deviation of what does.
    """
    force = np.abs(line.steps.reading - line.offset.value)
    heavy = force > 0.5 * force.max()
    return 0.47 * float(np.sqrt(np.mean((line.steps.moves[heavy] / force[heavy]) ** 2)))


def _safer(line: Calibration) -> Estimate:
    """Return the sensitivity with the larger error of scatter and, with fewer than 12 steps, of leaving one out."""
    few = line.steps.mass_kg.size < 12
    return max(line.sensitivity, line.left_out, key=lambda e: e.standard_error) if few else line.sensitivity


def _crosstalk(run: xr.Dataset, take: Take, gravity: float) -> list[str]:
    """Return what other channels read of the force that the weights make, in words."""
    told = []
    for name in map(str, run.data_vars):
        if name in ("mass", READING) or run[name].attrs.get("units") not in READING_UNITS:
            continue
        if float(np.ptp(run[name].values)) == 0:
            continue
        line = weights(run.assign({READING: run[name]}), take.settle_s, gravity, take.tolerance).sensitivity
        if abs(line.value) > float(student.ppf(1 - SURE / 2, line.freedom)) * line.standard_error:
            told.append(
                f"{name} reads {line} of the force that acts on {READING}: channels.{name}.crosstalk takes such a "
                "share off"
            )
    return told
