"""What friction adds to the sensor's reading over a stretch of constant command, from the two ends of the stretch.

There the amplitude is an exponential, y = c + z with z' = -wp z, so that the derivatives of g = 2^(-y^2) are g times
polynomials of p = y z and q = z^2. Value and three derivatives at both ends fix a polynomial of degree 7, which is
integrated against the sensor's exponential exactly (product integration). It costs one exponential per stretch, that
of its end, where six nodes cost five (docs/decisions/0001).
"""

from __future__ import annotations

import math
from functools import cache, lru_cache

import numpy as np
from numpy.polynomial import legendre

from frictionloop.loop.kernel.period_quadrature import segment_lengths, sensor_moments
from frictionloop.quantities.scalar_math import fma, step

DERIVATIVES = 4
"""Data per end: the value and three derivatives."""
TERMS = 6
"""Coefficients of an end: of 1, p, q, p^2, p q and p^3."""


@step
def end_step(y: float, z: float, c1: float, cp: float, cq: float, cpp: float, cpq: float, cppp: float) -> float:
    """What an end adds to the reading per newton of its friction: c1 + cp p + cq q + cpp p^2 + cpq p q + cppp p^3.

    p = y z and q = z^2 for an amplitude y that is z away from the command.
    """
    p, q = y * z, z * z
    return fma(p, fma(p, fma(p, cppp, cpp), fma(q, cpq, cp)), fma(q, cq, c1))


def end_terms(theta: float, turned: float) -> np.ndarray:
    """Return the coefficients of ``end_step`` at the start and at the end of a stretch, shape (2, 6).

    With g = 2^(-y^2), z' = y' = -l z over the stretch x = 0 to 1, and k = 2 l ln 2:
    g' = k p g, g'' = (k^2 p^2 - k l (p + q)) g, g''' = (k^3 p^3 - 3 k^2 l p (p + q) + k l^2 (p + 3 q)) g.

    Parameters
    ----------
    theta : float
        The sensor's corner (rad/s) times the length of the stretch.
    turned : float
        l, the plate's corner (rad/s) times the length.
    """
    w, k = end_weights(theta).T, 2.0 * math.log(2.0) * turned
    kl, kkl = k * turned, k * k * turned
    return np.stack(
        [
            w[0],
            k * w[1] - kl * w[2] + kl * turned * w[3],
            -kl * w[2] + 3.0 * kl * turned * w[3],
            k * k * w[2] - 3.0 * kkl * w[3],
            -3.0 * kkl * w[3],
            k**3 * w[3],
        ],
        axis=1,
    )


@lru_cache(maxsize=4096)
def end_weights(theta: float) -> np.ndarray:
    """Return W[e, j] with sum W[e, j] f^(j)(e) = int_0^1 theta e^(-theta (1 - x)) f(x) dx, exact for degree 7.

    e is 0 at the start and 1 at the end. One ``theta`` at a time, as in ``product_weights``.
    """
    weights = _hermite() @ sensor_moments(theta, 2 * DERIVATIVES)
    return np.asarray(weights.reshape(2, DERIVATIVES))


@cache
def _hermite() -> np.ndarray:
    """Return the matrix from Legendre moments to the weights of values and derivatives at the ends."""
    powers = range(2 * DERIVATIVES)
    basis = [legendre.Legendre.basis(degree, domain=[0.0, 1.0]) for degree in powers]
    data = [[b.deriv(j)(x) if j else b(x) for b in basis] for x in (0.0, 1.0) for j in range(DERIVATIVES)]
    return np.asarray(np.linalg.inv(np.array(data)).T)


def segment_ends(
    plate_hz: float, sensor_hz: float, switch_s: float, period_s: float, before: int, after: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the plate's decay over each segment of a period, and the terms of its ends, shape (segments, 2, 6).

    The terms count for the reading at the end of the period.
    """
    plate, sensor = 2.0 * math.pi * plate_hz, 2.0 * math.pi * sensor_hz
    lengths = segment_lengths(switch_s, period_s, before, after)
    left, terms = period_s, []
    for length in lengths.tolist():
        left -= length
        terms.append(end_terms(sensor * length, plate * length) * math.exp(-sensor * max(left, 0.0)))
    return np.exp(-plate * lengths), np.array(terms)
