"""The fit behind `PROTOTYPE`."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from frictionloop.perception import displacement_threshold_um
from frictionloop.perception.weighting import GRID_HZ, Prototype, gain_db

_START = ((4.0, 1.0), (40.0, 1.0), (10.0, 1.0), (200.0, 1.0), (300.0, 1.0))
_ZEROS = 2


def fit_prototype() -> Prototype:
    """Return the filter nearest to 1 / x_th(f) from 1 to 500 Hz, by least squares in dB over log f.

    Unknown are the gain and, of two pairs of zeros and three pairs of poles, the logarithms of frequency and
    damping ratio: poles and zeros stay in the left half plane, the filter is stable and of minimum phase.
    """
    target = -20 * np.log10(displacement_threshold_um(GRID_HZ))

    def error_db(unknown: np.ndarray) -> np.ndarray:
        return gain_db(_prototype(unknown), GRID_HZ) - target

    start = np.log([0.04, *np.ravel(_START)])
    found = least_squares(error_db, start, ftol=1e-13, xtol=1e-13, gtol=1e-13)
    return _prototype(found.x)


def _prototype(unknown: np.ndarray) -> Prototype:
    gain, *rest = np.exp(unknown).tolist()
    pairs = list(zip(rest[::2], rest[1::2], strict=True))
    return Prototype(gain, tuple(sorted(pairs[:_ZEROS])), tuple(sorted(pairs[_ZEROS:])))
