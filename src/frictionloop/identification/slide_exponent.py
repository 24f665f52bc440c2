"""How friction grows with the load within a slide."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.stats import linregress

from frictionloop.identification.estimate import Estimate

Array = NDArray[np.float64]

LEAST_LOADS = 0.05
"""Relative spread of the load below which its exponent cannot be told (assumed)."""


def load_exponent(f: Array, n: Array, rate_hz: float) -> Estimate:
    """Return n of log f = c + n log N over means of a tenth of a second."""
    pieces = max(int(f.size / (0.1 * rate_hz)), 3)
    pairs = [
        (float(a.mean()), float(b.mean()))
        for a, b in zip(np.array_split(f, pieces), np.array_split(n, pieces), strict=True)
    ]
    good = np.array([pair for pair in pairs if min(pair) > 0])
    if len(good) < 3 or good[:, 1].std() < LEAST_LOADS * good[:, 1].mean():
        return Estimate(math.nan, math.inf, "", 1.0)
    line = linregress(np.log(good[:, 1]), np.log(good[:, 0]))
    return Estimate(float(line.slope), float(line.stderr), "", len(good) - 2.0)
