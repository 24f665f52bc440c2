"""The force sensor of Section 2: noise is added to the force, then a first-order low-pass S(s)."""

from __future__ import annotations

import math

from frictionloop.parameters import LowpassSensor
from frictionloop.quantities import Lti
from frictionloop.quantities.arithmetic import fma, step


@step
def sensor_start(measured_n: float, normal: float, decay: float, noise_gain_n: float) -> float:
    """f_m e^(-ws T) + n (1 - e^(-ws T)): what one period leaves of the old reading, with noise n held over it."""
    return fma(decay, measured_n, noise_gain_n * normal)


@step
def sensor_node(measured_n: float, force_n: float, weight: float) -> float:
    """f_m += W f: one term of the rule for the integral over the period of ws e^(-ws (T - s)) f(s) ds."""
    return fma(weight, force_n, measured_n)


def linearise_sensor(sensor: LowpassSensor) -> Lti:
    """Return S(s) = 1 / (1 + s/ws), force (or noise) to measured force."""
    return Lti((1.0,), (1.0 / (2.0 * math.pi * sensor.cutoff_hz), 1.0))
