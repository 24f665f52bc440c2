"""Physiological tremor: a resonance driven by white noise, whose displacement and speed belong together.

    x'' + 2 pi b x' + w^2 x = u,    w^2 = (2 pi f)^2 + 2 (pi b)^2

The spectrum of x peaks at f exactly and is b wide at half power. The drive u is held over a control period, one unit
normal each, so the step is exact and x' is the derivative of x between samples as well.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_discrete_lyapunov

from frictionloop.quantities.counter_noise import normals
from frictionloop.quantities.scalar_math import fma, step

TANGENTIAL_STREAM, NORMAL_STREAM = 16, 17
"""Streams of the counter-based noise that drive the displacement along the stroke and the normal force."""
START_STREAM = 19
"""Stream of the stationary start: numbers 0 and 1 for the displacement, 2 and 3 for the normal force."""


class TremorState(NamedTuple):
    """Displacement x (or normal force) and its rate of change per second."""

    displacement: float
    rate: float


class TremorCoefficients(NamedTuple):
    """x[k+1] = a11 x + a12 x' + b1 z, x'[k+1] = a21 x + a22 x' + b2 z."""

    a11: float
    a12: float
    a21: float
    a22: float
    b1: float
    b2: float


@step
def tremor_step(state: TremorState, normal: float, coefficients: TremorCoefficients) -> TremorState:
    """State after one control period with a unit normal z held over it."""
    x, rate = state
    a11, a12, a21, a22, b1, b2 = coefficients
    return TremorState(fma(a11, x, fma(a12, rate, b1 * normal)), fma(a21, x, fma(a22, rate, b2 * normal)))


@lru_cache(maxsize=4096)
def tremor_coefficients(rms: float, frequency_hz: float, width_hz: float, dt: float) -> TremorCoefficients:
    """Return the coefficients for a standard deviation, in closed form of its stationary covariance.

    ``rms`` is that of x, in the unit wanted of x (m or N); the spectrum peaks at ``frequency_hz``, at most a tenth of
    the control rate, and is ``width_hz`` wide.
    """
    transition, drive = _held(frequency_hz, width_hz, dt)
    gain = rms / math.sqrt(_unit_covariance(transition, drive)[0, 0])
    (a11, a12), (a21, a22) = transition.tolist()
    b1, b2 = (gain * drive).tolist()
    return TremorCoefficients(a11, a12, a21, a22, b1, b2)


def tremor_start(coefficients: TremorCoefficients, seed: int, which: int = 0) -> TremorState:
    """Return a state drawn from the stationary distribution, so that the tremor has no start-up transient.

    ``which`` is 0 for the displacement along the stroke and 1 for the normal force: they are independent.
    """
    z0, z1 = normals(seed, START_STREAM, 2 * which, 2 * which + 2).tolist()
    if coefficients.b2 == 0.0:
        return TremorState(0.0, 0.0)
    r00, r10, r11 = _root(coefficients)
    return TremorState(r00 * z0, r10 * z0 + r11 * z1)


@lru_cache(maxsize=4096)
def _root(coefficients: TremorCoefficients) -> tuple[float, float, float]:
    """Return the lower root of the covariance; a population starts the same tremor again for every stroke."""
    # The root is taken before scaling: squares of a tremor of 1e-170 N would be no numbers any more.
    scale, unit = _scaled_covariance(coefficients)
    root = scale * cholesky(unit, lower=True)
    return float(root[0, 0]), float(root[1, 0]), float(root[1, 1])


def _scaled_covariance(coefficients: TremorCoefficients) -> tuple[float, np.ndarray]:
    a11, a12, a21, a22, b1, b2 = coefficients
    scale = math.hypot(b1, b2) or 1.0
    return scale, _unit_covariance(np.array([[a11, a12], [a21, a22]]), np.array([b1, b2]) / scale)


def _held(frequency_hz: float, width_hz: float, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return e^(A dt) and what a held drive adds, in closed form: populations take thousands of them."""
    decay = math.pi * width_hz
    omega2 = (2.0 * math.pi * frequency_hz) ** 2 + 2.0 * decay**2
    damped = math.sqrt(omega2 - decay**2)
    left, cosine, sine = math.exp(-decay * dt), math.cos(damped * dt), math.sin(damped * dt) / damped
    a11, a12 = left * (cosine + decay * sine), left * sine
    a21, a22 = -omega2 * a12, left * (cosine - decay * sine)
    return np.array([[a11, a12], [a21, a22]]), np.array([(1.0 - a11) / omega2, a12])


def _unit_covariance(transition: np.ndarray, drive: np.ndarray) -> np.ndarray:
    # Rates are some 100 times displacements; without scaling, the solution would lose digits.
    scale = np.array([1.0, math.sqrt(-transition[0, 1] / transition[1, 0])])
    ratio = scale[None, :] / scale[:, None]
    p = solve_discrete_lyapunov(transition / ratio, np.outer(drive * scale, drive * scale), method="bilinear")
    return np.asarray(p / np.outer(scale, scale))
