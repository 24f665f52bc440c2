"""What a calibration with weights says beyond its line: curvature, drift, friction of the pulley, a wrong unit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.constants import g as STANDARD_GRAVITY
from scipy.optimize import brentq, least_squares
from scipy.stats import linregress
from scipy.stats import t as student

from frictionloop.findings import Finding
from frictionloop.identification.calibration import Calibration
from frictionloop.identification.measured import Estimate
from frictionloop.identification.part import not_told, off_line
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.checks import BELOW_1, number

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PulleyFriction:
    """The friction of a pulley, and the sensitivity freed from it."""

    exponent: Estimate
    """b: when a weight is put on e^-b of it arrives, when one is taken off up to e^b."""
    drag: Estimate
    """Force that is lost whatever the weight, N."""
    sensitivity: Estimate
    """Unit of the reading per N, with friction apart."""


def arriving(force_n: Array, direction: Array, exponent: float, drag_n: float = 0.0) -> Array:
    """Return what arrives of forces F that follow each other: the friction of the string acts against its motion.

    up: T = max(T before, e^-b F - d),   down: T = min(T before, e^b F + d),   at first T = F
    """
    rising = np.exp(-exponent) * force_n - drag_n
    falling = np.exp(exponent) * force_n + drag_n
    arrived = [float(force_n[0])]
    for k in range(1, force_n.size):
        arrived.append(max(arrived[-1], rising[k]) if direction[k] > 0 else min(arrived[-1], falling[k]))
    return np.array(arrived)


def pulley_friction(calibration: Calibration, gravity_m_s2: float = STANDARD_GRAVITY) -> PulleyFriction:
    """Return the friction of the pulley from a calibration that went up and down.

    Least squares of reading = offset + k T over offset, k, b and d, T as in `arriving`; standard errors from its
    Jacobian. A swing that shakes the pulley loose lowers b: what is found is the friction that was left, not that of
    the bearing. Friction that acts the same way at all steps cannot be told from the sensitivity.

    Parameters
    ----------
    calibration : Calibration
        From `weights`, with weights put on and taken off.
    gravity_m_s2 : float
        As given to `weights`.

    Raises
    ------
    FrictionloopError
        For fewer than six steps, or fewer than two up or two down.
    """
    steps = calibration.steps
    force, way = steps.mass_kg * gravity_m_s2, steps.direction
    up, down = int(np.sum(way > 0)), int(np.sum(way < 0))
    if force.size < 6 or min(up, down) < 2:
        raise must_be("recording: steps of mass", f"{up} up, {down} down", "at least 6, two each way")
    scale, span_n = calibration.sensitivity.value, float(np.ptp(force))

    def residuals(x: Array) -> Array:
        given = x[0] * span_n + x[1] * arriving(force, way, x[2], x[3] * span_n)
        return (given - steps.reading / scale) / span_n

    starts = [np.array([calibration.offset.value / scale / span_n, 1.0, b, 0.0]) for b in (0.0, 0.05, 0.2)]
    fits = [least_squares(residuals, start, xtol=1e-15, ftol=1e-15, gtol=1e-15) for start in starts]
    best = min(fits, key=lambda fit: float(fit.cost))
    freedom = force.size - 4
    error = np.sqrt(np.diag(np.linalg.pinv(best.jac.T @ best.jac)) * 2 * best.cost / freedom).tolist()
    _, k, exponent, drag = best.x.tolist()
    return PulleyFriction(
        Estimate(exponent, error[2], "", freedom),
        Estimate(drag * span_n, error[3] * span_n, "N", freedom),
        Estimate(k * scale, error[1] * abs(scale), calibration.sensitivity.unit, freedom),
    )


def r2_with_friction(loads_n: Sequence[float], exponent: float) -> float:
    """Return R2 of a perfect sensor calibrated up and down these loads over a pulley with friction b.

    For many loads from 0 and small b, 1/R2 - 1 is close to 4 b^2 (less what the first steps down, where the string has
    not begun to slip back, take off).

    Parameters
    ----------
    loads_n : sequence of float
        Rising loads in N, at least two, none negative; the last is visited once, the others twice.
    exponent : float
        b, not negative (`friction_exponent` of identification/rigs/weights).

    Raises
    ------
    FrictionloopError
        For loads that do not rise, or a negative exponent.
    """
    loads = np.asarray(loads_n, dtype=float)
    if loads.ndim != 1 or loads.size < 2 or not np.all(np.diff(loads) > 0) or loads[0] < 0:
        raise must_be("loads_n", loads.tolist(), "two or more, rising from 0 on", "N")
    number("exponent", exponent, "", 0.0)
    visits = np.concatenate([loads, loads[-2::-1]])
    return (
        float(linregress(visits, arriving(visits, np.sign(np.diff(visits, prepend=visits[0])), exponent)).rvalue) ** 2
    )


def exponent_for_r2(r2: float, loads_n: Sequence[float]) -> float:
    """Return the friction b of a pulley that lowers R2 to this value, the inverse of `r2_with_friction`.

    Parameters
    ----------
    r2 : float
        From 0.5 to below 1.
    loads_n : sequence of float
        As there.

    Raises
    ------
    FrictionloopError
        For an R2 out of range, or that no friction gives with these loads.
    """
    number("r2", r2, "", 0.5, BELOW_1)
    strongest = 2.0
    while r2_with_friction(loads_n, strongest) > r2 and strongest < 16:
        strongest *= 2
    if strongest >= 16:
        raise must_be("r2", r2, f"higher with {len(loads_n)} loads")
    return float(brentq(lambda b: r2_with_friction(loads_n, b) - r2, 0.0, strongest, xtol=1e-12))


SURE = 0.01
"""Chance below which a bend or a drift is called real (assumed)."""
FACTORS = {9.80665: "kg", 1000.0: "mN"}
"""Slopes in N/N that a unit taken for N makes, and the unit."""
HEAVY_KG = 20.0
"""Mass from which on grams are asked about (assumed)."""


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
    findings: tuple[Finding, ...]


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
        told.append(off_line("bend", 100 * bend.value, "% of the span", "f_m"))
    if drifts:
        told.append(off_line("drift", 1e3 * drift.value * span_n, "mN", "f_m"))
    friction = None
    try:
        friction = pulley_friction(found) if unordered else None
    except FrictionloopError:
        friction = None
    if friction is None:
        told.append(not_told("friction of the pulley", "fewer than two steps up and two down"))
    elif _real(friction.exponent) and abs(friction.exponent.value) > 1e-3:
        told.append(off_line("friction of the pulley", 100 * friction.exponent.value, "%", "f_m"))
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


def _units(found: Calibration) -> Iterator[Finding]:
    """Suspect aloud a slope or a mass that a wrong unit would make."""
    slope = abs(found.sensitivity.value)
    for factor, unit in FACTORS.items() if found.steps.unit == "N" else ():
        if abs(slope / factor - 1) < 0.1 or abs(slope * factor - 1) < 0.1:
            more = {"path": "sensitivity", "low": 0.5, "high": 2.0}
            yield Finding("UNIT-DOUBT", value=slope, unit="N/N", remedy=f"unit = {unit}", more=more)
    most = float(found.steps.mass_kg.max())
    if most > HEAVY_KG:
        more = {"path": "mass", "low": 0.0, "high": HEAVY_KG}
        yield Finding("UNIT-DOUBT", value=most, unit="kg", remedy="unit = g", more=more)
