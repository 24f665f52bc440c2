"""Where a recorded disturbance jumps as sliding friction does not: a finger that lands, lifts, or meets an edge."""

from __future__ import annotations

import numpy as np

from frictionloop.parameters import Recording, System

WITHIN_S = 0.025
"""The mean of so long before a moment and after it is compared; tremor and texture average out (chosen)."""
MUCH = 12.0
"""Times the median change from which on one is a jump (chosen by hand, on one finger's recording: its slides have 3 to
5 at most, its landing and its lift 26 and more)."""
APART = 8
"""Times that width by which two jumps are apart (chosen)."""
MOST = 3
"""Most jumps that are named (chosen)."""


def jumps(force_n: np.ndarray, rate_hz: float) -> list[tuple[int, float]]:
    """Return sample and change in N of each jump, the largest first."""
    width = max(round(WITHIN_S * rate_hz), 1)
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


def said(system: System, duration_s: float) -> str:
    """Return where the part of a recorded disturbance that runs jumps; empty where it does not, or that was asked."""
    signal = system.disturbance
    if not isinstance(signal, Recording):
        return ""
    from frictionloop.recordings.read import scaled
    from frictionloop.recordings.told import found

    told = found(signal)
    if told.on_plate_s is not None:
        return ""
    force, rate_hz, _, _ = scaled(signal, "N")
    where = jumps(np.asarray(force, dtype=float)[: round(duration_s * rate_hz)], rate_hz)
    if not where:
        return ""
    named = [f"{1e3 * size:.3g} mN at {told.from_s + at / rate_hz:.4g} s" for at, size in where[:MOST]]
    more = f", and elsewhere {len(where) - MOST} more" if len(where) > MOST else ""
    return (
        f"The recorded disturbance jumps by {', '.join(named)} of the file{more}: where that is a finger that lands or "
        "lifts, it counts as friction, and what is left looks smaller. --disturbance.start_s and --disturbance.stop_s "
        "cut it out."
    )
