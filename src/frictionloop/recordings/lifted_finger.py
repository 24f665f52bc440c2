"""Where a recorded friction stays near 0: the finger is then off the plate, or stands still."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictionloop.recordings.clean import SHOWN, longest, stretch, stretches
from frictionloop.recordings.signs import lingers

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
