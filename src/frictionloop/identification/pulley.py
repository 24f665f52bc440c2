"""What a calibration up and down tells of the friction between weights and sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.constants import g as STANDARD_GRAVITY
from scipy.optimize import brentq, least_squares
from scipy.stats import linregress

from frictionloop.identification.calibration import Calibration
from frictionloop.identification.estimate import Estimate
from frictionloop.quantities import FrictionloopError
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

    Parameters
    ----------
    force_n : array
        Forces in N, shape (steps,).
    direction : array
        1 where the force has grown, -1 where it has shrunk, of the same shape.
    exponent : float
        b; below zero, by chance, the formula still gives a line for each way.
    drag_n : float
        d in N.
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
        raise FrictionloopError(
            f"recording: 'mass' has {force.size} steps, {up} up and {down} down: must have at least six, two of each"
        )
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
        raise FrictionloopError("loads_n: must be at least two rising forces in N, none negative")
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
        raise FrictionloopError(f"r2 = {r2!r}: no friction gives it with {len(loads_n)} loads; must be higher")
    return float(brentq(lambda b: r2_with_friction(loads_n, b) - r2, 0.0, strongest, xtol=1e-12))
