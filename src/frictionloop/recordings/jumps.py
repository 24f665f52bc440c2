"""Where a recorded disturbance jumps as sliding friction does not: a finger that lands, lifts, or meets an edge."""

from __future__ import annotations

import numpy as np

WITHIN_S = 0.025
"""The mean of so long before a moment and after it is compared; tremor and texture average out (chosen)."""
MUCH = 12.0
"""Times the median change from which on one is a jump (chosen by hand, on one finger's recording: its slides have 3 to
5 at most, its landing and its lift 26 and more)."""
APART = 8
"""Times that width by which two jumps are apart (chosen)."""


def jumps(force_n: np.ndarray, rate_hz: float) -> list[tuple[int, float]]:
    """Return sample and change in N of each jump, the largest first."""
    width = max(round(WITHIN_S * rate_hz), 1)
    force_n = np.asarray(force_n, dtype=float)
    if force_n.size < 4 * width:
        return []
    sums = np.concatenate([[0.0], np.cumsum(force_n)])
    means = (sums[width:] - sums[:-width]) / width
    change, steps = np.abs(means[width:] - means[:-width]), np.abs(np.diff(force_n))
    if not steps.any():
        return []
    # Of a coarse converter most changes are 0, and one of a step or a few of it is no jump.
    usual_n = max(float(np.median(change)), float(np.median(steps[steps > 0.0])))
    over = change > MUCH * usual_n
    starts = np.flatnonzero(np.diff(np.concatenate([[False], over, [False]]).astype(np.int8)))
    peaks = [(a + int(np.argmax(change[a:b])), float(change[a:b].max())) for a, b in starts.reshape(-1, 2).tolist()]
    found: list[tuple[int, float]] = []
    for at, size in sorted(peaks, key=lambda each: -each[1]):
        if all(abs(at + width - other) > APART * width for other, _ in found):  # one landing has several
            found.append((at + width, size))
    return found
