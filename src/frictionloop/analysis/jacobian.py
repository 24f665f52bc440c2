"""The Jacobian of a compiled step by central differences, for steps that are smooth where they rest."""

from __future__ import annotations

import numpy as np

from frictionloop.analysis.rest import LawStep, sizes
from frictionloop.analysis.state_space import Array
from frictionloop.quantities import FrictionloopError

FINEST, COARSEST, SHARES = 1e-8, 1e-3, 11
"""Steps of the differences over the size of what is varied: rounding limits small ones, curvature large ones."""
ALIKE, KINK = 1e-5, 1e-3
"""How far two neighbouring steps may differ, and the slopes on both sides, relative to the largest slope."""
NOTHING = 1e-11
"""A slope below this, in sizes over sizes, is rounding."""


def jacobian(step: LawStep, point: Array, what: str) -> Array:
    """Return d(x', u)/d(x, f_r, f_m) at a point, shape (states + 1, states + 2).

    Per column the step is the one whose result differs least from that of the next finer one. A law is smooth where
    such a step is found and the slopes to both sides agree: sign(s) and sqrt|s| of a sliding mode grow without
    bound as the step shrinks, |s| has two slopes.

    Raises
    ------
    FrictionloopError
        The law is not smooth at the point.
    """
    out = np.append(sizes(point[:-2]), sizes(point[-1:]))
    centre, size = step(point), sizes(point)
    columns = [_column(step, point, centre, j, size[j], out) for j in range(point.size)]
    if any(column is None for column in columns):
        raise FrictionloopError(f"{what}: its step is not smooth at rest, so it has no linear analysis; simulate it")
    return np.column_stack([column for column in columns if column is not None])


def _column(step: LawStep, point: Array, centre: Array, j: int, size: float, out: Array) -> Array | None:
    shares = np.geomspace(COARSEST, FINEST, SHARES)
    slopes, kinks = np.empty((2, SHARES, centre.size))
    for k, share in enumerate(shares):
        ahead, behind = point.copy(), point.copy()
        ahead[j] += share * size
        behind[j] -= share * size
        forward, backward = step(ahead), step(behind)
        slopes[k] = (forward - backward) / (ahead[j] - behind[j])
        kinks[k] = (forward - 2.0 * centre + backward) / (share * size)
    scaled = size / out
    apart = np.max(np.abs(np.diff(slopes, axis=0)) * scaled, axis=1)
    bends = np.max(np.abs(kinks) * scaled, axis=1)[:-1]
    largest = max(1.0, float(np.max(np.abs(slopes[SHARES // 2]) * scaled)))
    smooth = (apart <= ALIKE * largest) & (bends <= KINK * largest)
    if not smooth.any():
        return None
    best = int(np.argmin(np.where(smooth, apart, np.inf)))
    return np.where(np.abs(slopes[best]) * scaled < NOTHING, 0.0, slopes[best])
