"""Where a finger slides in a long record, and the zeros of its channels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.onsets import quiet_noise

Array = NDArray[np.float64]

SMOOTH_S = 0.05
"""Time over which a position is turned into a speed, and a load is judged (assumed)."""
STEADY = 0.3
"""A finger slides where its speed is within this share of the median of the slide (assumed)."""
SLOWEST_M_S = 2e-3
SHORTEST_S = 0.3


def without_zero(values: Array, free: NDArray[np.bool_], margin: int) -> Array:
    """Return a channel less the line through the medians of the stretches without contact."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], free.astype(np.int8), [0]]))).reshape(-1, 2)
    inner = [(a + margin, b - margin) for a, b in edges.tolist() if b - a > 4 * margin]
    if not inner:
        return values
    centres = [(a + b) / 2 for a, b in inner]
    return np.asarray(values - np.interp(np.arange(values.size), centres, [np.median(values[a:b]) for a, b in inner]))


def slide_rows(touching: NDArray[np.bool_], speed: Array, rate_hz: float) -> list[tuple[int, int]]:
    """Return rows between which a finger touches and slides evenly."""
    least = max(SLOWEST_M_S, 5 * quiet_noise(speed))
    moving = touching & (np.abs(speed) > least)
    signed = np.where(moving, np.sign(speed), 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], signed, [0.0]])))
    runs = []
    for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        if signed[a] == 0 or (b - a) < SHORTEST_S * rate_hz:
            continue
        usual = float(np.median(np.abs(speed[a:b])))
        even = np.flatnonzero(np.abs(np.abs(speed[a:b]) - usual) < STEADY * usual)
        first, stop = a + int(even[0]), a + int(even[-1]) + 1
        if stop - first >= SHORTEST_S * rate_hz:
            runs.append((first, stop))
    return runs
