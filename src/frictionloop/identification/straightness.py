"""What a calibration with weights says beyond its line: curvature, drift, friction of the pulley, a wrong unit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.constants import g as STANDARD_GRAVITY
from scipy.stats import t as student

from frictionloop.identification.calibration import Calibration
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.pulley import PulleyFriction, pulley_friction
from frictionloop.quantities import FrictionloopError

SURE = 0.01
"""Chance below which a bend or a drift is called real (assumed)."""
_FACTORS = {9.80665: "kilograms were taken for newtons", 1000.0: "grams or millinewtons were taken for units of 1"}


class Straightness(NamedTuple):
    """What a line through weights leaves."""

    curvature: Estimate
    """How much more the reading grows than the line, at the largest force over the span of the reading."""
    curved: bool
    drift: Estimate
    """Change of the residual from the first to the last step in N, the line taken off."""
    drifts: bool
    friction: PulleyFriction | None
    """None where it cannot be told."""
    told: tuple[str, ...]
    """What a reader should know, in sentences."""


def straightness(found: Calibration) -> Straightness:
    """Return curvature, drift and friction of the pulley, each with its uncertainty, and what to say of them.

        residual_i = c (x_i^2 - x_i) span + d k_i + scatter,   x = (force - least)/span, k from 0 to 1 in order

    by least squares with the line's two parameters, where there are steps enough. Drift cannot be told from curvature
    when weights are only added: then curvature alone is fitted.

    Parameters
    ----------
    found : Calibration
        From `weights`.
    """
    mass = found.steps.mass_kg
    span = float(np.ptp(mass))
    x = (mass - mass.min()) / span
    order = np.linspace(0.0, 1.0, mass.size)
    unordered = bool(np.any(found.steps.direction < 0))
    columns = [np.ones_like(x), x, x**2 - x, *([order] if unordered else [])]
    span_n = span * STANDARD_GRAVITY
    bend, drift = _fitted(columns, found.residuals_n / span_n)
    curved, drifts = _real(bend), unordered and _real(drift)
    told = []
    if curved:
        told.append(f"the reading is bent: {100 * bend.value:.2g} % of the span, at most, off the line")
    if drifts:
        told.append(f"the reading drifts by {1e3 * drift.value * span_n:.2g} mN from the first weight to the last")
    friction = None
    if not unordered:
        told.append("weights were only put on: the friction of a pulley and a drift cannot be told from steps up only")
    else:
        try:
            friction = pulley_friction(found)
        except FrictionloopError as refused:
            told.append(str(refused))
        else:
            if _real(friction.exponent) and abs(friction.exponent.value) > 1e-3:
                told.append(f"a pulley's friction takes {100 * friction.exponent.value:.2g} % of each force on its way")
    told += _units(found)
    return Straightness(
        Estimate(bend.value / 4, bend.standard_error / 4, "", bend.freedom),
        curved,
        Estimate(drift.value * span_n, drift.standard_error * span_n, "N", drift.freedom),
        drifts,
        friction,
        tuple(told),
    )


def _fitted(columns: list[NDArray[np.float64]], residual: NDArray[np.float64]) -> tuple[Estimate, Estimate]:
    """Return the third coefficient and the fourth, with standard errors; not known where there are too few steps."""
    matrix = np.stack(columns, axis=1)
    freedom = residual.size - matrix.shape[1]
    if freedom < 1 or np.linalg.matrix_rank(matrix) < matrix.shape[1]:
        return Estimate(0.0, np.inf, "", 1.0), Estimate(0.0, np.inf, "", 1.0)
    values, *_ = np.linalg.lstsq(matrix, residual, rcond=None)
    left = float(np.sum((residual - matrix @ values) ** 2)) / freedom
    errors = np.sqrt(left * np.diag(np.linalg.inv(matrix.T @ matrix)))
    found = [Estimate(float(v), float(e), "", freedom) for v, e in zip(values, errors, strict=True)]
    return found[2], found[3] if len(found) > 3 else Estimate(0.0, np.inf, "", 1.0)


def _real(found: Estimate) -> bool:
    """Return whether a value differs from 0 more than chance makes it."""
    if not np.isfinite(found.standard_error):
        return False
    return abs(found.value) > float(student.ppf(1 - SURE / 2, found.freedom)) * found.standard_error


def _units(found: Calibration) -> list[str]:
    """Suspect aloud a slope or a mass that a wrong unit would make."""
    told = []
    slope = abs(found.sensitivity.value)
    if found.steps.unit == "N":
        for factor, what in _FACTORS.items():
            if abs(slope / factor - 1) < 0.1 or abs(slope * factor - 1) < 0.1:
                told.append(f"the slope is {slope:.3g} N/N, near {factor:.4g} or its inverse: {what}?")
    most = float(found.steps.mass_kg.max())
    if most > 20:
        told.append(f"the largest mass is {most:g} kg: are these grams?")
    return told
