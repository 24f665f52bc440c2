"""The friction law under ultrasonic vibration, equation (1), its inverse and what it can reach."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.parameters import Friction, System
from frictionloop.quantities.arithmetic import exp2, step


@step
def remaining_step(y: float) -> float:
    """g/f0 = e^(-tau a^2) = 2^(-y^2), equation (1) for an amplitude y = a / halving_amplitude_um."""
    return exp2(-y, y)


def halving_amplitude_um(susceptibility_per_um2: np.ndarray | float) -> np.ndarray:
    """Return the amplitude sqrt(ln 2 / tau) in um that halves friction, for tau in um^-2 of any shape."""
    return np.sqrt(np.log(2.0) / np.asarray(susceptibility_per_um2))


def friction_force(amplitude_um: np.ndarray | float, friction: Friction) -> np.ndarray:
    """Return g(a) = f0 exp(-tau a^2) in N, equation (1) without d, for amplitudes in um of any shape."""
    return friction.nominal_n * np.exp(-friction.susceptibility_per_um2 * np.square(amplitude_um))


def amplitude_for(force_n: np.ndarray | float, friction: Friction) -> np.ndarray:
    """Return the amplitude a = sqrt(ln(f0/f)/tau) in um at which g(a) = f, the inverse of equation (1).

    ``force_n`` lies in (0, f0]; outside it no amplitude exists and the result is NaN.
    """
    force = np.asarray(force_n, dtype=float)
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
    """
    floor = float(friction_force(system.plate.max_amplitude_um, system.friction))
    return Band(floor + float(np.max(disturbance_n)), system.friction.nominal_n + float(np.min(disturbance_n)))


def sensitivity_n_per_um(amplitude_um: float, friction: Friction) -> float:
    """Return dg/da = -2 tau a g(a) in N/um, the slope at an operating point (negative: vibration lowers friction)."""
    return -2.0 * friction.susceptibility_per_um2 * amplitude_um * float(friction_force(amplitude_um, friction))
