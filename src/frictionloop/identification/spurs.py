"""Lines in a spectrum that stand above what is around them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from frictionloop.identification.noise import NoiseSpectrum

SPUR = 10.0
"""A line is a spur if its power is above so many times the median around it (assumed)."""
AROUND = 101


class Spur(NamedTuple):
    """A line in the spectrum."""

    frequency_hz: float
    rms_n: float


def spurs_of(spectrum: NoiseSpectrum) -> tuple[list[Spur], NDArray[np.bool_]]:
    """Return the lines, the highest first, and which frequencies are free of them."""
    power = spectrum.power_density
    ground = median_filter(power, min(AROUND, power.size // 4 * 2 + 1), mode="nearest")
    high = power > SPUR * ground
    step_hz = float(spectrum.frequency_hz[1] - spectrum.frequency_hz[0])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], high.astype(np.int8), [0]]))).reshape(-1, 2)
    clean = np.ones(power.size, dtype=bool)
    found = []
    for first, stop in edges.tolist():
        shoulders = np.concatenate([power[max(first - 10, 0) : max(first - 3, 0)], power[stop + 3 : stop + 10]])
        if stop - first > 6 or power[first:stop].max() < SPUR / 2 * shoulders.max(initial=0.0):
            continue  # a hump, or part of one, not a line
        around = slice(max(first - 2, 0), stop + 2)
        clean[around] = False
        above = np.maximum(power[around] - ground[around], 0.0)
        excess = max(float(np.sum(power[around] - ground[around])) * step_hz, 0.0)
        hertz = float(np.sum(spectrum.frequency_hz[around] * above) / np.sum(above))
        found.append(Spur(hertz, math.sqrt(excess)))
    return sorted(found, key=lambda spur: -spur.rms_n), clean
