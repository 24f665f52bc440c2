"""Which samples of a channel stand at an end of its range in runs, as clipping leaves them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.plateaus import Plateaus

FLAT_RUN = 4
"""Equal samples in a row at an end of the range that count as clipped (assumed: noise makes three)."""
LEVELS = 32
"""A channel with fewer different values is one of steps, such as masses, and does not clip (assumed)."""
STANDING, MOVING = 0.9, 0.7
"""A step of weights clips where more than the first share of its samples is at one end, and in the other steps less
than the second (assumed: with a coarse converter it is that much everywhere)."""
APART = 0.05
"""Masses that differ by more than this share of the largest cannot give one reading (assumed: readings are rounded)."""
RESTING = 0.1
"""An end as near to the median as this share of the range is where the channel rests (assumed)."""


def clipped(values: NDArray[np.float64], full_scale: float | None = None) -> NDArray[np.bool_]:
    """Return which samples stand at the largest or the least value in runs of four or more.

    An end where a signal merely turns has more samples just inside it than at it; at one where it clips it is the other
    way round. A channel of few levels does not clip, nor does one at the value at which it rests.
    """
    at = np.zeros(values.size, dtype=bool)
    span = float(np.ptp(values)) if values.size else 0.0
    if span == 0 or np.unique(values[:: max(values.size // 20000, 1)]).size < LEVELS:
        return at
    middle = float(np.median(values))
    for end in (float(values.max()), float(values.min())):
        if abs(end - middle) < RESTING * span:
            continue
        long, inside = at_end(values, end, span)
        if clips(int(long.sum()), inside, end, full_scale):
            at |= long
    return at


def clipped_share(values: NDArray[np.float64]) -> float:
    """Return the share of samples that are clipped."""
    return float(np.mean(clipped(values))) if values.size else 0.0


def at_end(values: NDArray[np.float64], end: float, span: float) -> tuple[NDArray[np.bool_], int]:
    """Return which samples stand at an end of the range in runs, and how many are within a hundredth of it."""
    near = np.abs(values - end) <= 1e-9 * span
    inside = int(np.count_nonzero(np.abs(values - end) <= 0.01 * span))
    at = np.zeros(values.size, dtype=bool)
    if not near.any():
        return at, inside
    edges = np.flatnonzero(np.diff(np.concatenate([[0], near.astype(np.int8), [0]])))
    runs = edges.reshape(-1, 2)
    for first, stop in runs[runs[:, 1] - runs[:, 0] >= FLAT_RUN]:
        at[first:stop] = True
    return at, inside


def clips(there: int, inside: int, end: float, full_scale: float | None) -> bool:
    """Return whether an end with so many samples at it, and just inside it, is one where the channel clips."""
    if not there:
        return False
    return 2 * there >= inside or bool(full_scale and math.isclose(abs(end), full_scale, rel_tol=1e-3))


def clipped_steps(steps: Plateaus) -> NDArray[np.bool_]:
    """Return which steps of a calibration stand at an end of the sensor's range.

    Two different masses give exactly the same reading there, or the noise of the others is missing at that end.
    """
    found = np.zeros(steps.reading.size, dtype=bool)
    near = 1e-9 * float(np.ptp(steps.reading))
    for k, end in enumerate((float(steps.reading.min()), float(steps.reading.max()))):
        at = np.abs(steps.reading - end) <= near
        shares = steps.at_ends[:, k]
        others = float(np.median(shares[~at])) if not at.all() else 1.0
        several = float(np.ptp(steps.mass_kg[at])) > APART * float(np.ptp(steps.mass_kg))
        if several or (float(shares[at].max()) > STANDING and others < MOVING):
            found |= at
    return found
