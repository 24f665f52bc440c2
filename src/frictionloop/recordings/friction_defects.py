"""Where a recorded friction has no numbers, goes both ways, leaves the plate, or jumps as sliding does not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities import Array, FrictionloopError

SHOWN = 3
"""Gaps that are listed."""
LEAST = 10
"""Steps of a part that may be taken for a recording (chosen)."""


def clean_part(values: Array, at_s: Array) -> tuple[str, str]:
    """Return where values are no numbers, in words, and what cuts out the longest part without such; else ""."""
    bad = ~np.isfinite(values)
    if not bad.any():
        return "", ""
    gaps = stretches(bad)
    start, stop = longest(~bad)
    if stop - start < LEAST:
        return "", ""
    more = f" and {len(gaps) - SHOWN} more" if len(gaps) > SHOWN else ""
    where = f"; no number at {', '.join(stretch(at_s[a], at_s[b]) for a, b in gaps[:SHOWN])}{more}"
    return where, f", or {taking(at_s[start], at_s[stop])}"


def refuse_gaps(
    path: str,
    values: Array,
    place: Callable[[int], str],
    where: str = "",
    cut: str = "",
    accepted: str = "a finite number",
) -> None:
    """Refuse a NaN or an infinity, naming the first and where it stands, where all are, and what cuts them out."""
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        more = f" (and {bad.size - 1} more)" if bad.size > 1 else ""
        raise FrictionloopError(f"{path}: {place(int(bad[0]))}{more}{where}; accepted: {accepted}{cut}")


def taking(start_s: float, stop_s: float) -> str:
    """Return what takes the longest part without a gap."""
    flags = f"--disturbance.start_s {start_s:.9g} --disturbance.stop_s {stop_s:.9g}"
    return f"the longest part without a gap: {flags} (or --setpoint)"


def stretch(start_s: float, stop_s: float) -> str:
    """Return a stretch in words."""
    return f"{start_s:.9g} s" if start_s == stop_s else f"{start_s:.9g} to {stop_s:.9g} s"


def longest(of: np.ndarray) -> tuple[int, int]:
    """Return the first and last index of the longest stretch of True, (0, 0) without any."""
    return max(stretches(of), key=lambda part: part[1] - part[0], default=(0, 0))


def stretches(of: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last index of each stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], of, [False]]).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


Signs = Literal["", "both", "below"]
"""What is seen of a force: nothing, strokes both ways, or strokes against the sensor's axis."""
BOTH_WAYS = 0.05
"""Share of the samples that each sign must have (chosen)."""
ZERO = 0.1
"""Magnitude below which a sample has no sign, as a share of the 95th percentile of the magnitude (chosen)."""
LOW, LOW_SHARE = 0.3, 0.08
"""A finger turns round quickly: of its strokes at most this share of the samples lies between `ZERO` and `LOW`.

A sine about 0 has 13 % there, as 2/pi (asin 0.3 - asin 0.1), and normal noise 29 % (chosen below both).
"""
MOST_TURNS_HZ = 5.0
"""Changes of sign per second from which on no finger turns round (chosen: 2.5 strokes to and fro)."""


def signs_of(force: NDArray[np.floating], duration_s: float) -> Signs:
    """Return whether a force, its mean left in, looks like friction with the sign of the motion.

    "both": at least `BOTH_WAYS` of the samples are above, and as many below, `ZERO` of the 95th percentile of the
    magnitude; signs change fewer than `MOST_TURNS_HZ` times per second; and few samples lie just beside 0, for a finger
    that turns round or lifts passes there quickly. What varies about 0 by intent, a sine or noise, lingers there.
    "below": the mean is below 0, and by more than the standard deviation.

    Friction that varies within a stroke by more than 1 to 4, or turns more often, is not found; a square wave about 0
    is taken for strokes.
    """
    size = np.abs(force)
    top = float(np.quantile(size, 0.95))
    if top == 0.0:
        return ""
    up, down = force > ZERO * top, force < -ZERO * top
    turns = int(np.count_nonzero(np.diff(up[up | down].astype(np.int8))))
    both = min(up.mean(), down.mean()) >= BOTH_WAYS
    if both and turns < MOST_TURNS_HZ * duration_s and not lingers(force):
        return "both"
    return "below" if force.mean() < 0 and -force.mean() > force.std() else ""


def lingers(force: NDArray[np.floating]) -> bool:
    """Return whether many samples lie just beside 0, where a finger that lands, lifts or turns round passes quickly."""
    size = np.abs(force)
    top = float(np.quantile(size, 0.95))
    return float(np.mean((size > ZERO * top) & (size < LOW * top))) >= LOW_SHARE


NEAR = 0.03
"""Magnitude below which no finger slides, as a share of the 95th percentile of the magnitude (chosen)."""
LEAST_S = 0.05
"""A finger that turns round is there for less (chosen)."""


def off_plate(
    force: NDArray[np.floating], rate_hz: float, at_s: NDArray[np.floating]
) -> tuple[str, tuple[float, float]] | None:
    """Return the stretches near 0 in words and the longest part without one, both in s; None without any.

    That part begins and ends where the magnitude passes half of its median.

    Nothing is found in a signal that lingers beside 0, as a sine about 0 or one that just reaches it, and noise do.
    """
    size = np.abs(force)
    near = size < NEAR * np.quantile(size, 0.95)
    off = [part for part in stretches(near) if part[1] - part[0] > LEAST_S * rate_hz]
    if not off or lingers(force):
        return None
    on = np.ones(size.size, dtype=bool)
    for first, last in off:
        on[first : last + 1] = False
    more = f" and {len(off) - SHOWN} more" if len(off) > SHOWN else ""
    seen_s = [[round(float(at_s[k]), 4) for k in part] for part in off[:SHOWN]]
    first, last = longest(on)
    # Where the finger lands and lifts the force passes half of what it has there.
    slides = np.flatnonzero(size[first : last + 1] >= np.median(size[first : last + 1]) / 2.0)
    first, last = first + int(slides[0]), first + int(slides[-1])
    return ", ".join(stretch(*each) for each in seen_s) + more, (float(at_s[first]), float(at_s[last]))


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
    peaks = [(a + int(np.argmax(change[a : b + 1])), float(change[a : b + 1].max())) for a, b in stretches(over)]
    found: list[tuple[int, float]] = []
    for at, size in sorted(peaks, key=lambda each: -each[1]):
        if all(abs(at + width - other) > APART * width for other, _ in found):  # one landing has several
            found.append((at + width, size))
    return found
