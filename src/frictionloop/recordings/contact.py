"""Where a recorded friction stays near 0: the finger is then off the plate, or stands still."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictionloop.recordings.clean import SHOWN, longest, said, stretches
from frictionloop.recordings.signs import lingers

NEAR = 0.03
"""Magnitude below which no finger slides, as a share of the 95th percentile of the magnitude (chosen)."""
LEAST_S = 0.05
"""A finger that turns round is there for less (chosen)."""


def off_plate(force: NDArray[np.floating], rate_hz: float, since_s: float) -> tuple[str, tuple[float, float]] | None:
    """Return the stretches near 0 in words and the longest part without one, both in s; None without any.

    Nothing is found in a signal that lingers beside 0, as a sine about 0 or one that just reaches it, and noise do.

    Parameters
    ----------
    force, rate_hz
        Force with its mean left in, in any unit, and samples per second.
    since_s
        Time of the first sample in the file.
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
    at_s = [[round(since_s + k / rate_hz, 4) for k in part] for part in off[:SHOWN]]
    first, last = longest(on)
    return ", ".join(said(*each) for each in at_s) + more, (since_s + first / rate_hz, since_s + last / rate_hz)
