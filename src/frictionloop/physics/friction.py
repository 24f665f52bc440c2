"""The friction law under ultrasonic vibration, equation (1), and its inverse."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeGuard

import numpy as np

from frictionloop.parameters import FrictionLaw, FrictionLimit
from frictionloop.physics.vibration import GAUSSIAN, Vibration, inverse_of, vibration_of
from frictionloop.quantities.scalar_math import exp2, step
from frictionloop.quantities.value_checks import as_numbers, numbers

LARGEST_UM = 1000.0
"""Largest amplitude that is searched for (assumed: far beyond any plate)."""


@step
def remaining_step(y: float) -> float:
    """g/f0 = e^(-tau a^2) = 2^(-y^2), equation (1) for an amplitude y = a / halving_amplitude_um."""
    return exp2(-y, y)


def halving_amplitude_um(susceptibility_per_um2: np.ndarray | float) -> np.ndarray:
    """Return the amplitude sqrt(ln 2 / tau) in um that halves friction, for tau in um^-2 of any shape."""
    return np.sqrt(np.log(2.0) / np.asarray(susceptibility_per_um2))


class Held(NamedTuple):
    """A friction law of any kind under a finger whose limit and moisture stay as they are."""

    nominal_n: float
    vibration: Vibration
    coefficients: Any
    occluded: float = 0.0


Law = FrictionLimit | Held


def limit_law(friction: FrictionLimit, factor: float = 1.0, occluded: float = 0.0) -> Held:
    """Return the law of friction parameters, its limit times a factor."""
    law = vibration_of(friction)
    return Held(friction.nominal_n * factor, law, law.coefficients_of(friction), occluded)


def is_gaussian(friction: Law) -> TypeGuard[FrictionLaw]:
    """Tell whether equation (1) describes a law."""
    return isinstance(friction, FrictionLaw) and vibration_of(friction) is GAUSSIAN


def friction_force(amplitude_um: np.ndarray | float, friction: Law) -> np.ndarray:
    """Return g(a) in N, for equation (1) f0 exp(-tau a^2) without d (paper, Sec. 2.1).

    Parameters
    ----------
    amplitude_um : array or float
        Vibration amplitudes a >= 0 in um, zero-to-peak, of any shape.
    friction : FrictionLimit
        f0 and what its kind has besides.

    Raises
    ------
    FrictionloopError
        For an amplitude that is negative or not finite.
    """
    numbers("amplitude_um", amplitude_um, "um", 0.0)
    if is_gaussian(friction):
        return friction.nominal_n * np.exp(-friction.susceptibility_per_um2 * np.square(amplitude_um))
    nominal_n, law, coefficients, occluded = friction if isinstance(friction, Held) else limit_law(friction)
    shares = [law.step(float(a), occluded, coefficients) for a in np.ravel(amplitude_um)]
    return nominal_n * np.reshape(shares, np.shape(amplitude_um))


def slope_per_um2(amplitude_um: float, friction: Law) -> float:
    """Return dg/d(a^2) in N/um^2, in closed form for equation (1), else by differences of a ten-thousandth."""
    if is_gaussian(friction):
        return -friction.susceptibility_per_um2 * float(friction_force(amplitude_um, friction))
    square = amplitude_um * amplitude_um
    step = 1e-4 * max(square, 1e-2)
    low, high = max(square - step, 0.0), square + step
    forces = friction_force(np.sqrt([low, high]), friction)
    return float(forces[1] - forces[0]) / (high - low)


def amplitude_for(force_n: np.ndarray | float, friction: Law) -> np.ndarray:
    """Return the amplitude in um at which g(a) = f: for equation (1) sqrt(ln(f0/f)/tau).

    Parameters
    ----------
    force_n : array or float
        Friction forces f in N, 0 < f <= f0, of any shape; outside this range no amplitude exists, which gives NaN.
    friction : FrictionLimit
        f0 and what its kind has besides; of a law from outside amplitudes up to 1 mm are searched.

    Raises
    ------
    FrictionloopError
        For forces that are not numbers.
    """
    force = as_numbers("force_n", force_n, "N")
    inside = (force > 0) & (force <= friction.nominal_n)
    if not is_gaussian(friction):
        nominal_n, law, coefficients, occluded = friction if isinstance(friction, Held) else limit_law(friction)
        inverse = inverse_of(law)
        given = [inverse(nominal_n, float(f), occluded, LARGEST_UM, coefficients) for f in force.ravel()]
        found = np.reshape(given, force.shape)
        return np.where(inside & (found < 0.999 * LARGEST_UM), found, np.nan)
    exponent = np.log(friction.nominal_n / np.where(inside, force, 1.0))
    return np.where(inside, np.sqrt(np.abs(exponent) / friction.susceptibility_per_um2), np.nan)
