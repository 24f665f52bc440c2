"""The notch: the second-order section that takes a resonance out of the loop gain."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray


class Section(NamedTuple):
    """(b0 + b1/z + b2/z^2) / (1 + a1/z + a2/z^2)."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


def notch_section(notch_hz: float, depth: float, width: float, rate_hz: float) -> Section:
    """Return (s^2 + 2 depth w s + w^2) / (s^2 + 2 width w s + w^2) as a section, w = 2 pi notch_hz.

    Bilinear with the frequency prewarped, s/w = (z - 1)/(t (z + 1)), t = tan(pi notch_hz / rate_hz), in closed form:
    gain 1 at 0 and at half the rate, depth/width at the notch. For depth <= width no coefficient is above 2.

    Parameters
    ----------
    notch_hz
        Centre in Hz, above 0 and below half the rate.
    depth, width
        Damping ratios of numerator (at least 0) and denominator (above 0).
    rate_hz
        Rate of the control periods.
    """
    t = math.tan(math.pi * notch_hz / rate_hz)
    above, below, scale = 1.0 + t * t, 2.0 * t, 1.0 / (1.0 + 2.0 * width * t + t * t)
    turn = 2.0 * (t * t - 1.0) * scale
    return Section(
        (above + depth * below) * scale,
        turn,
        (above - depth * below) * scale,
        turn,
        (above - width * below) * scale,
    )


def section_response(section: Section, frequency_hz: ArrayLike, rate_hz: float) -> NDArray[np.complex128]:
    """Return the response of a section at z = exp(j 2 pi f / rate), complex, f in Hz."""
    b0, b1, b2, a1, a2 = section
    back = np.exp(-2j * np.pi * np.asarray(frequency_hz, dtype=float) / rate_hz)
    return np.asarray((b0 + (b1 + b2 * back) * back) / (1.0 + (a1 + a2 * back) * back))
