"""Poles that several decays share: the matrix pencil, at rising orders."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
NEAR_HZ, NEAR_Q = 0.01, 0.3
"""A pole is stable if at the order below there is one as near in frequency and in Q, as shares (assumed)."""


class Pole(NamedTuple):
    """One damped oscillation at one order."""

    order: int
    frequency_hz: float
    q: float
    stable: bool


def stabilisation(decays: Sequence[Array], rate_hz: float, orders: Sequence[int]) -> list[Pole]:
    """Return the poles of a sum of damped oscillations, common to several decays, at each order.

        y_n = sum_k A_k z_k^n,    z = exp((-w/(2 Q) + j w_d)/rate),    w_d = w sqrt(1 - 1/(4 Q^2))

    The Hankel matrices of all decays stand side by side, so that they have one set of poles; of their left singular
    vectors, as many as the order, the shift from row to row is solved by least squares (matrix pencil).

    Parameters
    ----------
    decays : sequence of array
        Free decays without mean, of any lengths.
    rate_hz : float
        Samples per second.
    orders : sequence of int
        Numbers of modes to try, rising; those for which the shortest decay has too few samples are not.

    Notes
    -----
    Source: Hua and Sarkar, IEEE Trans. ASSP 38 (1990) 814.
    """
    shortest = min(decay.size for decay in decays)
    orders = [order for order in orders if 4 * order + 4 <= shortest]
    if not orders:
        return []
    rows = max(min(shortest // 2, 300), 2 * max(orders) + 2)
    windows = [np.lib.stride_tricks.sliding_window_view(decay, rows) for decay in decays]
    # The left singular vectors of a wide matrix are the eigenvectors of its square, a sum over decays.
    powers, vectors = np.linalg.eigh(sum(each.T @ each for each in windows))
    vectors = vectors[:, np.argsort(powers)[::-1]]
    found: list[Pole] = []
    before: list[Pole] = []
    for order in orders:
        signal = vectors[:, : 2 * order]
        shift, *_ = np.linalg.lstsq(signal[:-1], signal[1:], rcond=None)
        here = [_pole(order, z, rate_hz, before) for z in np.linalg.eigvals(shift) if z.imag > 0 and abs(z) < 1]
        before = sorted(here, key=lambda pole: pole.frequency_hz)
        found += before
    return found


def _pole(order: int, z: complex, rate_hz: float, before: Sequence[Pole]) -> Pole:
    s = complex(np.log(z)) * rate_hz
    hertz, q = abs(s) / (2 * np.pi), abs(s) / (-2 * s.real)
    near = [each for each in before if abs(each.frequency_hz - hertz) <= NEAR_HZ * hertz]
    return Pole(order, hertz, q, any(abs(each.q - q) <= NEAR_Q * q for each in near))
