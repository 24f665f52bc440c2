"""What a pulley leaves of a weight: friction that acts against the motion, so that what arrives depends on the way.

With tension T1 of the weight and T2 at the frame, bearing friction mu at the radius r of the axle and the string at
radius R, a pulley that is just about to turn has (torque = mu r times the load of both tensions at the wrap angle)

    T1/T2 = e^(+-b),   sinh(b/2) = sin(wrap/2) e / sqrt(1 - e^2),   e = mu r / R.

A string that slides over a pulley that does not turn has b = mu_s wrap (Euler and Eytelwein). The easier one happens.
In between, T2 stays where it was: the play operator of hysteresis.
"""

from __future__ import annotations

import math
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from frictionloop.parameters.rigs import Pulley

Array = NDArray[np.float64]


def friction_exponent(pulley: Pulley) -> float:
    """Return b, the logarithm of the largest ratio of the two tensions, without the drag."""
    wrap = math.radians(pulley.wrap_deg)
    sliding = pulley.string_friction * wrap
    lever = pulley.bearing_friction * pulley.axle_radius_mm / pulley.radius_mm
    if lever >= 1:
        return sliding
    turning = 2 * math.asinh(abs(math.sin(wrap / 2)) * lever / math.sqrt(1 - lever**2))
    return min(turning, sliding)


def string_friction_for(exponent: float, wrap_deg: float = 90.0) -> float:
    """Return the friction of string on a peg that does not turn which gives b = ``exponent``."""
    return exponent / math.radians(wrap_deg)


def bearing_friction_for(exponent: float, pulley: Pulley) -> float:
    """Return the friction of the bearing of a pulley like ``pulley`` which gives b = ``exponent``; the string holds."""
    ratio = math.sinh(exponent / 2) / abs(math.sin(math.radians(pulley.wrap_deg) / 2))
    return ratio / math.sqrt(1 + ratio**2) * pulley.radius_mm / pulley.axle_radius_mm


def pulled(weight_n: Array, pulley: Pulley) -> Array:
    """Return T2 in N over time for tensions T1 >= 0, shape (samples,); at first both are equal.

    T2 = min(max(T2 before, e^-b T1 - d), e^b T1 + d), never below zero, d the drag.
    """
    exponent = friction_exponent(pulley)
    low = np.maximum(math.exp(-exponent) * weight_n - pulley.drag_n, 0.0).tolist()
    high = (math.exp(exponent) * weight_n + pulley.drag_n).tolist()

    def play(before: float, band: tuple[float, float]) -> float:
        return min(max(before, band[0]), band[1])

    following = accumulate(zip(low[1:], high[1:], strict=True), play, initial=float(weight_n[0]))
    return np.fromiter(following, float, len(low))
