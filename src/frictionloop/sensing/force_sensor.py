"""The force sensors: that of Section 2, and one on springs with a converter."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from frictionloop.parameters import LowpassSensor, SuspendedSensor
from frictionloop.quantities import Lti
from frictionloop.quantities.scalar_math import ROUND, fma, step


@step
def sensor_start(measured_n: float, normal: float, decay: float, noise_gain_n: float) -> float:
    """f_m e^(-ws T) + n (1 - e^(-ws T)): what one period leaves of the old reading, with noise n held over it."""
    return fma(decay, measured_n, noise_gain_n * normal)


@step
def sensor_node(measured_n: float, force_n: float, weight: float) -> float:
    """f_m += W f: one term of the rule for the integral over the period of ws e^(-ws (T - s)) f(s) ds."""
    return fma(weight, force_n, measured_n)


class SuspensionState(NamedTuple):
    """Force of the springs in N, its rate over the resonance's angular frequency, and force behind the pole."""

    spring_n: float
    rate_n: float
    filtered_n: float


class SuspensionCoefficients(NamedTuple):
    """Exact step over a stretch of constant force: x1, x2 of the springs and x3 of the pole, from x and the force."""

    a11: float
    a12: float
    b1: float
    a21: float
    a22: float
    b2: float
    a31: float
    a32: float
    a33: float
    b3: float


class NoiseCoefficients(NamedTuple):
    """n' = decay n + gain z per control period, z a unit normal."""

    decay: float
    gain: float


class Converter(NamedTuple):
    """1/step and step in N, and the largest magnitude that is told."""

    per_step: float
    step_n: float
    range_n: float


@step
def suspension_step(state: SuspensionState, force_n: float, coefficients: SuspensionCoefficients) -> SuspensionState:
    """x1'' + w/Q x1' + w^2 x1 = w^2 F and x3' = wc (x1 - x3), exact for a force held over the step."""
    x1, x2, x3 = state
    a11, a12, b1, a21, a22, b2, a31, a32, a33, b3 = coefficients
    return SuspensionState(
        fma(a11, x1, fma(a12, x2, b1 * force_n)),
        fma(a21, x1, fma(a22, x2, b2 * force_n)),
        fma(a31, x1, fma(a32, x2, fma(a33, x3, b3 * force_n))),
    )


@step
def convert_step(force_n: float, converter: Converter) -> float:
    """Nearest step of the converter, within its range."""
    per_step, step_n, range_n = converter
    whole = (force_n * per_step + ROUND) - ROUND
    return min(max(whole * step_n, -range_n), range_n)


@lru_cache(maxsize=1024)
def suspension_coefficients(sensor: SuspendedSensor | LowpassSensor, dt: float) -> SuspensionCoefficients:
    """Return the exact step over ``dt`` s; a sensor without a suspension is one whose springs follow at once."""
    corner = 2.0 * math.pi * sensor.cutoff_hz
    if isinstance(sensor, LowpassSensor):
        decay = math.exp(-corner * dt)
        return SuspensionCoefficients(0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, decay, 1.0 - decay)
    from scipy.linalg import expm  # only here: a run without suspension starts 0.1 s sooner

    omega = 2.0 * math.pi * sensor.resonance_hz
    rates = np.array(
        [[0, omega, 0, 0], [-omega, -omega / sensor.q, 0, omega], [corner, 0, -corner, 0], [0, 0, 0, 0]], dtype=float
    )
    (a11, a12, _, b1), (a21, a22, _, b2), (a31, a32, a33, b3), _ = expm(rates * dt).tolist()
    return SuspensionCoefficients(a11, a12, b1, a21, a22, b2, a31, a32, a33, b3)


def noise_coefficients(sensor: SuspendedSensor | LowpassSensor, dt: float) -> NoiseCoefficients:
    """Return how the noise behind the pole goes on from one control period to the next.

    A density before the pole gives an Ornstein-Uhlenbeck noise of ``noise_rms_n``; the sensor of Section 2 holds one
    draw over a period, before its pole.
    """
    decay = math.exp(-2.0 * math.pi * sensor.cutoff_hz * dt)
    held = isinstance(sensor, LowpassSensor)
    return NoiseCoefficients(decay, sensor.noise_rms_n * (1.0 - decay if held else math.sqrt(1.0 - decay * decay)))


def converter(sensor: SuspendedSensor | LowpassSensor) -> Converter:
    """Return the converter; the sensor of Section 2 has none, which is one with steps of 2^-50 N."""
    if isinstance(sensor, LowpassSensor):
        return Converter(2.0**50, 2.0**-50, math.inf)
    return Converter(1.0 / sensor.step_n, sensor.step_n, sensor.range_n - sensor.step_n)


def linearise_sensor(sensor: SuspendedSensor | LowpassSensor) -> tuple[Lti, ...]:
    """Return S(s) as blocks in series: springs w^2/(s^2 + s w/Q + w^2) if there are any, then the pole 1/(1 + s/wc)."""
    pole = Lti((1.0,), (1.0 / (2.0 * math.pi * sensor.cutoff_hz), 1.0))
    if isinstance(sensor, LowpassSensor):
        return (pole,)
    omega = 2.0 * math.pi * sensor.resonance_hz
    return Lti((1.0,), (1.0 / omega**2, 1.0 / (sensor.q * omega), 1.0)), pole
