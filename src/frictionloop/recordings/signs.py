"""Is a force that was measured along one axis friction of strokes both ways? Its sign is then that of the motion."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

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
