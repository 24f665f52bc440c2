"""Stability of a sampled loop from its frequency response alone, for a controller of which nothing else is known."""

from __future__ import annotations

import numpy as np

from frictionloop.analysis.state_space import Array, Complex
from frictionloop.quantities import FrictionloopError


def poles_outside(loop_gain: Complex, frequency_hz: Array, period_s: float, integrators: int = 1) -> int:
    """Return how many closed-loop poles lie outside the unit circle, from G at frequencies up to rate/2.

    F(z) = (1 + G(z)) (1 - 1/z)^k has no poles outside the circle when G has none but its k integrators, and is 1 at
    infinity: by the argument principle the phase of F turns by -pi for each zero outside from z = 1 to z = -1.

    Parameters
    ----------
    loop_gain
        G at ``frequency_hz``, complex; no pole outside the unit circle.
    frequency_hz
        Rising frequencies in Hz, from where F is real to a few degrees, up to half the rate itself, and so dense that
        G goes straight in between.
    period_s
        Control period.
    integrators
        Poles of G at z = 1.

    Raises
    ------
    FrictionloopError
        A grid too coarse to follow the phase, or that does not start low enough.
    """
    F = (1 + loop_gain) * (-np.expm1(-2j * np.pi * frequency_hz * period_s)) ** integrators
    steps = np.angle(F[1:] / F[:-1])
    turned = float(np.sum(steps)) + float(np.angle(F[0] * np.sign(F[0].real)))
    turns = turned / np.pi
    # Near -1 a short step of G turns F far, and rightly so: a chord tells the side on which -1 is passed.
    coarse = (np.abs(steps) > 2.5) & (np.abs(np.diff(loop_gain)) > 0.3)
    if np.any(coarse) or abs(turns - round(turns)) > 0.05:
        raise FrictionloopError(
            f"frequency_hz: the grid from {frequency_hz[0]:g} to {frequency_hz[-1]:g} Hz is too coarse or starts too "
            f"high to count the poles of the closed loop"
        )
    return round(-turns)
