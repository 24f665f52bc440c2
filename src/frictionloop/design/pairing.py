"""Zeros and poles of a filter as the numerators and denominators of sections: which go together, and in which order."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from frictionloop.analysis.state_space import Array, Complex
from frictionloop.control.filtered_pi import FREE
from frictionloop.design.quadruple import Quadruple
from frictionloop.quantities import FrictionloopError

ANGLES = np.append(np.geomspace(1e-5, np.pi, 2000), 0.0)
"""Angles of z at which the gain of sections is looked at."""
LEAST_DAMPING = 0.2
"""Damping ratio of zeros below which a section is better left free (assumed)."""


def zeros_of(filter_: Quadruple) -> tuple[Complex, float]:
    """Return zeros and leading gain of D + C (z - A)^-1 B: finite generalised eigenvalues of its system matrix."""
    from scipy.linalg import eigvals

    A, B, C, D = filter_
    through = float(D[0, 0])
    if not (np.any(B) and np.any(C)):
        return np.linalg.eigvals(A).astype(complex), through
    size = float(np.abs(C @ B).max()) + abs(through)
    if abs(through) > 1e-9 * size:
        return np.linalg.eigvals(A - B @ C / through).astype(complex), through
    left = np.block([[A, B], [C, np.zeros((1, 1))]])
    right = np.diag([1.0] * len(A) + [0.0])
    zeros = eigvals(left, right)
    zeros = zeros[np.isfinite(zeros) & (np.abs(zeros) < 1e6)]
    probe = np.exp(1j)  # anywhere that is neither pole nor zero: the gain is what makes the response right there
    ratio = np.prod(probe - zeros) / np.prod(probe - np.linalg.eigvals(A))
    return zeros, float((filter_.at(probe)[0, 0, 0] / ratio).real)


def paired(zeros: Complex, poles: Complex) -> list[tuple[Array, Array]]:
    """Return b and a of each section, highest power of 1/z last, paired and ordered for the least total gain.

    Each pair of poles takes the pair of zeros with which its gain varies least over frequency, but zeros whose inverse
    would ring (`_rings`) go to the two pairs of poles farthest from z = 1. These two sections come first, because the
    law leaves them free; of the orders left the one is taken in which the sections, scaled so that none is ever above
    1, need the least gain behind them.
    """
    from scipy.optimize import linear_sum_assignment

    if len(poles) == 0:
        return []
    back = np.exp(-1j * ANGLES[::8])
    unders, overs = _pairs(poles), _pairs(zeros)
    # As many b as a: a zero less is a period of delay, 1/z, which comes as a leading 0.
    overs += [np.array([1.0])] * (len(unders) - len(overs))
    delays = len(poles) - len(zeros)
    padded = [np.concatenate([b, np.zeros(3 - len(b))]) for b in overs]
    free = set(np.argsort([-np.abs(1 - np.roots(a)).min() for a in unders])[:FREE].tolist())
    swing = np.array([[np.ptp(np.log(_size(b, a, back))) for b in padded] for a in unders])
    swing += [[1e3 * (i not in free and _rings(b)) for b in overs] for i in range(len(unders))]
    mates = linear_sum_assignment(swing)[1]
    rows = _ordered([(padded[mate], a) for a, mate in zip(unders, mates, strict=True)], free, back)
    return _delayed(rows, delays) if delays else rows


def _pairs(roots: Complex) -> list[Array]:
    """Return 1 + c1/z + c2/z^2 for each conjugate pair, and for neighbours among the real roots."""
    real = np.sort(roots[np.abs(roots.imag) <= 1e-12].real)[::-1]
    found = [np.array([1.0, -2 * r.real, abs(r) ** 2]) for r in roots[roots.imag > 1e-12]]
    found += [np.poly(real[i : i + 2]) for i in range(0, len(real), 2)]
    return [np.concatenate([c, np.zeros(3 - len(c))]) for c in found]


def _size(b: Array, a: Array, back: Complex) -> Array:
    return np.asarray(np.maximum(np.abs(np.polyval(b[::-1], back) / np.polyval(a[::-1], back)), 1e-12))


def _rings(b: Array) -> bool:
    """Return whether 1/b is unstable or rings: a root of b not inside the unit circle, or with little damping."""
    roots = np.roots(b).astype(complex)
    roots = np.log(roots[np.abs(roots) > 1e-6])
    return bool(np.any(-roots.real < np.maximum(LEAST_DAMPING * np.abs(roots), 1e-9)))


def _ordered(rows: list[tuple[Array, Array]], free: set[int], back: Complex) -> list[tuple[Array, Array]]:
    sizes = [np.log(_size(b, a, back)) for b, a in rows]

    def gain(order: tuple[int, ...]) -> float:
        so_far, total = np.zeros(back.size), 0.0
        for i in order:
            so_far = so_far + sizes[i]
            total += float(so_far.max())
            so_far = so_far - so_far.max()
        return total

    orders = (order for order in permutations(range(len(rows))) if set(order[:FREE]) == free)
    return [rows[i] for i in min(orders, key=gain)]


def _delayed(rows: list[tuple[Array, Array]], delays: int) -> list[tuple[Array, Array]]:
    """Put periods of delay into sections with room: b0 + b1/z + 0 becomes 0 + b0/z + b1/z^2."""
    out = []
    for num, a in rows:
        b = num
        while delays and b[2] == 0.0:
            b, delays = np.array([0.0, b[0], b[1]]), delays - 1
        out.append((b, a))
    if delays:
        raise FrictionloopError(f"sections: {delays} more periods of delay than the sections have room for")
    return out
