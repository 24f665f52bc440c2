"""Where the force is evaluated inside a control period, and with which weights it enters the sensor.

With the amplitude command held, a(t) is an exponential, so f(t) is smooth between two commands and the sensor's
convolution over a period is a quadrature. Six Gauss-Lobatto nodes err by 3e-11 N at 5 kHz where ten first-order-hold
substeps err by 8e-5 N and cost twice the exponentials (docs/decisions/0001).
"""

from __future__ import annotations

from functools import cache

import numpy as np

NODES = 6
"""Gauss-Lobatto nodes per segment of constant command."""


@cache
def gauss_lobatto(nodes: int = NODES) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights on [0, 1], ends included; exact for polynomials of degree 2 nodes - 3.

    Abramowitz and Stegun 25.4.32: interior nodes are the zeros of P'_{n-1}, weights 2 / (n (n-1) P_{n-1}(x)^2).
    """
    legendre = np.polynomial.legendre.Legendre.basis(nodes - 1)
    x = np.concatenate([[-1.0], np.sort(legendre.deriv().roots().real), [1.0]])
    return (x + 1.0) / 2.0, 1.0 / (nodes * (nodes - 1) * legendre(x) ** 2)


def segment_nodes(switch_s: np.ndarray, period_s: float, segments: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return node times, weights (s) and time since the segment's start, each of shape (5 segments + 1, lanes).

    One segment spans the period; with two, the command changes ``switch_s`` after the sample and the node at the
    switch belongs to both.
    """
    x, w = (part[:, None] for part in gauss_lobatto())
    switch = np.atleast_1d(switch_s)[None, :]
    if segments == 1:
        whole = np.full_like(switch, period_s)
        return x * whole, w * whole, x * whole
    rest = period_s - switch
    times = np.concatenate([x * switch, switch + x[1:] * rest])
    weights = np.concatenate([w * switch, w[1:] * rest])
    weights[NODES - 1] += w[0, 0] * rest[0]
    return times, weights, np.concatenate([x * switch, x[1:] * rest])
