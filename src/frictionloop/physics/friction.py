"""The friction law under ultrasonic vibration, equation (1), its inverse and what it can reach."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.parameters import FrictionLaw, System, check_system
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.arithmetic import exp2, step
from frictionloop.quantities.checks import as_numbers, numbers


@step
def remaining_step(y: float) -> float:
    """g/f0 = e^(-tau a^2) = 2^(-y^2), equation (1) for an amplitude y = a / halving_amplitude_um."""
    return exp2(-y, y)


def halving_amplitude_um(susceptibility_per_um2: np.ndarray | float) -> np.ndarray:
    """Return the amplitude sqrt(ln 2 / tau) in um that halves friction, for tau in um^-2 of any shape."""
    return np.sqrt(np.log(2.0) / np.asarray(susceptibility_per_um2))


def friction_force(amplitude_um: np.ndarray | float, friction: FrictionLaw) -> np.ndarray:
    """Return g(a) = f0 exp(-tau a^2) in N, equation (1) without d (paper, Sec. 2.1).

    Parameters
    ----------
    amplitude_um : array or float
        Vibration amplitudes a >= 0 in um, zero-to-peak, of any shape.
    friction : FrictionLaw
        f0 and tau.

    Raises
    ------
    FrictionloopError
        For an amplitude that is negative or not finite.
    """
    numbers("amplitude_um", amplitude_um, "um", 0.0)
    return friction.nominal_n * np.exp(-friction.susceptibility_per_um2 * np.square(amplitude_um))


def amplitude_for(force_n: np.ndarray | float, friction: FrictionLaw) -> np.ndarray:
    """Return the amplitude a = sqrt(ln(f0/f)/tau) in um at which g(a) = f, the inverse of equation (1).

    Parameters
    ----------
    force_n : array or float
        Friction forces f in N, 0 < f <= f0, of any shape; outside this range no amplitude exists, which gives NaN.
    friction : FrictionLaw
        f0 and tau.

    Raises
    ------
    FrictionloopError
        For forces that are not numbers.
    """
    force = as_numbers("force_n", force_n, "N")
    inside = (force > 0) & (force <= friction.nominal_n)
    exponent = np.log(friction.nominal_n / np.where(inside, force, 1.0))
    return np.where(inside, np.sqrt(np.abs(exponent) / friction.susceptibility_per_um2), np.nan)


class Band(NamedTuple):
    """Lowest and highest force that can be reached, in N."""

    low_n: float
    high_n: float


def reachable(system: System, disturbance_n: np.ndarray | float = 0.0) -> Band:
    """Return the band of forces reachable at every value of the disturbance: [g(a_max) + max d, f0 + min d].

    The band is empty (low above high) when the disturbance swings wider than f0 - g(a_max), as with the paper's
    printed numbers.

    Parameters
    ----------
    system : System
        Its friction law and the plate's a_max.
    disturbance_n : array or float
        Values of the disturbance d in N, at least one, of any shape.

    Raises
    ------
    FrictionloopError
        For what is not a System, or a disturbance that is empty or not finite.
    """
    check_system(system)
    disturbance = numbers("disturbance_n", disturbance_n, "N")
    if disturbance.size == 0:
        raise FrictionloopError("disturbance_n is empty: must hold at least one force in N")
    floor = float(friction_force(system.plate.max_amplitude_um, system.friction))
    return Band(floor + float(disturbance.max()), system.friction.nominal_n + float(disturbance.min()))
