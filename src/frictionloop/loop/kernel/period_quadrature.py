"""How a control period is divided, and how a smooth force inside it enters the sensor.

While the amplitude command is held friction is known from the ends of the stretch. The disturbance is
taken at six Gauss-Lobatto nodes, whose weights integrate its interpolant against the sensor's exponential exactly
(product integration), so that they hold for any sensor cutoff (docs/decisions/0001). A late command splits the period
in two, a fast plate in more. All this is for a paper's loop, in which nothing feeds back within a period.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache

import numpy as np
from numpy.polynomial import legendre

from frictionloop import parameters as block
from frictionloop.parameters import System
from frictionloop.parameters.block import Represented

NODES = 6
"""Gauss-Lobatto nodes per segment of the period."""
PLATE_PER_SEGMENT = 0.035
"""Largest plate cutoff times segment length: keeps the error of a full swing of the amplitude below 2e-8 N."""
MAX_SEGMENTS = 28
"""Most segments on one side of a command; with more the plate is faster than the control rate."""
QUADRATURE = Represented(
    "the rule for the paper's loop",
    {
        block.LowpassPlate: "kind cutoff_hz max_amplitude_um",
        block.ResonantPlate: "kind frequency_hz q max_amplitude_um",
        block.FrictionLimit: "nominal_n",
        block.FrictionLaw: "susceptibility_per_um2",
        block.Friction: "kind",
        block.LowpassSensor: "kind cutoff_hz noise_rms_n",
        block.Sliding: "kind",
        block.RigidFinger: "kind",
        block.Timing: "rate_hz delay_s model",
        block.PiController: "kind kp ki",
    },
    {},
)
"""What else there is runs by substeps."""


def suits_quadrature(system: System) -> bool:
    """Return whether a system is a paper's loop, in which nothing feeds back within a period."""
    blocks = system.friction, system.plate, system.sensor, system.controller, system.finger, system.motion
    return all(type(block) in QUADRATURE.fields and not any(QUADRATURE.missing(block)) for block in blocks)


@cache
def gauss_lobatto(nodes: int = NODES) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights on [0, 1], ends included; exact for polynomials of degree 2 nodes - 3.

    Abramowitz and Stegun 25.4.32: interior nodes are the zeros of P'_{n-1}, weights 2 / (n (n-1) P_{n-1}(x)^2).
    """
    top = legendre.Legendre.basis(nodes - 1)
    x = np.concatenate([[-1.0], np.sort(top.deriv().roots().real), [1.0]])
    return (x + 1.0) / 2.0, 1.0 / (nodes * (nodes - 1) * top(x) ** 2)


@lru_cache(maxsize=4096)
def product_weights(theta: float) -> np.ndarray:
    """Return W_j with sum W_j f(x_j) = int_0^1 theta e^(-theta (1 - x)) f(x) dx, exact for degree nodes - 1.

    ``theta`` is the sensor's corner (rad/s) times the segment's length.
    """
    return np.asarray(_interpolation() @ sensor_moments(theta, NODES))


def sensor_moments(theta: float, count: int) -> np.ndarray:
    """Return int_0^1 theta e^(-theta (1 - x)) P_j(2 x - 1) dx for the first ``count`` Legendre polynomials P_j."""
    x, w = legendre.leggauss(48)
    # Beyond 40 time constants before the end the kernel is below 1e-17.
    reach = min(1.0, 40.0 / max(theta, 1e-300))
    back = (x + 1.0) / 2.0 * reach
    kernel = w / 2.0 * reach * theta * np.exp(-theta * back)
    return np.asarray(kernel @ legendre.legvander(1.0 - 2.0 * back, count - 1))


@cache
def _interpolation() -> np.ndarray:
    """Return the matrix from Legendre moments to node weights."""
    return np.asarray(np.linalg.inv(legendre.legvander(2.0 * gauss_lobatto()[0] - 1.0, NODES - 1).T))


def segments_needed(cutoff_hz: float, length_s: float) -> int:
    """Return how many segments a stretch of constant command needs for this plate (0 for no stretch)."""
    return math.ceil(max(cutoff_hz * length_s / PLATE_PER_SEGMENT, 1e-9)) if length_s > 0 else 0


def segment_lengths(switch_s: float, period_s: float, before: int, after: int) -> np.ndarray:
    """Return the lengths of the segments in s.

    The command changes ``switch_s`` after the sample; there are ``before`` equal segments up to then and ``after``
    equal ones to the end of the period.
    """
    return np.array([switch_s / max(before, 1)] * before + [(period_s - switch_s) / after] * after)


def segment_nodes(switch_s: float, period_s: float, before: int, after: int) -> np.ndarray:
    """Return node times in s, 5 segments + 1 of them; a node between two segments belongs to both."""
    x = gauss_lobatto()[0][1:]
    lengths = segment_lengths(switch_s, period_s, before, after)
    starts = [0.0, *np.cumsum(lengths)[:-1]]
    return np.concatenate([[0.0], *(start + x * length for start, length in zip(starts, lengths, strict=True))])


def segment_weights(corner_hz: float, switch_s: float, period_s: float, before: int, after: int) -> np.ndarray:
    """Return the weight of each node's force in the sensor's reading at the end of the period."""
    omega = 2.0 * math.pi * corner_hz
    lengths = segment_lengths(switch_s, period_s, before, after)
    weights = np.zeros((NODES - 1) * len(lengths) + 1)
    left = period_s
    for segment, length in enumerate(lengths.tolist()):
        left -= length
        first = segment * (NODES - 1)
        weights[first : first + NODES] += product_weights(omega * length) * math.exp(-omega * max(left, 0.0))
    return weights
