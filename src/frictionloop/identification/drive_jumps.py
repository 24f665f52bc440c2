"""Jumps of the plate's drive: from where to where each fall or rise of the vibration lasts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_closing

from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
WORST_MISFIT = 0.1
"""Most of a rise or fall that one time constant may leave unexplained (assumed)."""
LEAST_JUMP = 0.3
"""A jump is a change by more than this share of the largest (assumed)."""
CONSTANTS = 8.0
"""So many time constants after a jump are fitted: e^-8 is left."""


def jumps_of(envelope: Array, size: int) -> list[tuple[int, int, bool]]:
    """Return from where to where each fall lasts, from its steepest place to just before the next jump, and True.

    Without a fall these are the rises, and False: a rise beats where the drive is beside the resonance, a fall never
    does.
    """
    step = np.abs(envelope[2 * size :] - envelope[: -2 * size])
    largest = float(np.percentile(envelope, 99.5))
    # How long a rise takes is not known beforehand: twice the shortest stretch over which one is a jump is taken.
    edges, starts = np.zeros((0, 2), dtype=int), []
    for wide in (envelope.size // share for share in (400, 200, 100, 50)):
        found_before = edges.size > 0
        change = np.abs(envelope[2 * wide :] - envelope[: -2 * wide]) if wide > 0 else np.zeros(0)
        high = np.concatenate([[False], change > LEAST_JUMP * largest, [False]])
        # What flickers about the threshold is one jump.
        high = binary_closing(np.pad(high, 4 * wide), np.ones(4 * wide + 1))[4 * wide : -4 * wide or None]
        edges = np.flatnonzero(np.diff(high.astype(np.int8))).reshape(-1, 2)
        if found_before:
            break
    for a, b in edges.tolist():
        inner = slice(max(a + wide - 2 * size, 0), min(b + wide + 2 * size, step.size))
        starts.append(inner.start + int(np.argmax(step[inner])) + size)
    starts = [k for k in starts if k > 3 * size]
    if not starts:
        raise FrictionloopError(
            f"recording: the vibration never changes by {LEAST_JUMP:.0%} of its largest at once: must rise or fall "
            "after the drive is switched"
        )
    stops = [*(k - 3 * size for k in starts[1:]), envelope.size - size]
    found = [(a, b) for a, b in zip(starts, stops, strict=True) if b - a > 20 * size]
    falls = [(a, b, True) for a, b in found if envelope[b - 2 * size : b].mean() < 0.3 * envelope[a - 3 * size]]
    return falls or [(a, b, False) for a, b in found]
