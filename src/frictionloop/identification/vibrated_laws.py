"""How friction may fall with the amplitude: the law of equation (1) and two others to hold against it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LEAST_SHARE = 0.02
"""Least share of the friction that the threshold law leaves: its straight line would go on below 0 (assumed)."""


class VibratedLaw(NamedTuple):
    """One law; ``exponent(a, x, largest)`` is -log of the share of friction that is left."""

    name: str
    words: str
    exponent: Callable[[Array, Array, float], Array]
    start: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


def _gaussian(amplitude_um: Array, x: Array, largest_um: float) -> Array:
    return np.asarray(x[0] * (amplitude_um / largest_um) ** 2)


def _exponential(amplitude_um: Array, x: Array, largest_um: float) -> Array:
    return np.asarray(x[0] * amplitude_um / largest_um)


def _threshold(amplitude_um: Array, x: Array, largest_um: float) -> Array:
    beyond = np.maximum(amplitude_um / largest_um - x[1], 0.0)
    return np.asarray(-np.log(np.maximum(1.0 - x[0] * beyond, LEAST_SHARE)))


LAWS = (
    VibratedLaw("gaussian", "exp(-tau a^2)", _gaussian, (1.0,), (-5.0,), (50.0,)),
    VibratedLaw("exponential", "exp(-a/a1): contact of a rough surface", _exponential, (1.0,), (-5.0,), (50.0,)),
    VibratedLaw(
        "threshold", "1 up to a0, then falling in proportion", _threshold, (1.0, 0.2), (0.0, 0.0), (20.0, 0.95)
    ),
)
"""x[0] is the exponent at the largest amplitude (of the threshold law the slope there), so of the order of 1 for all.

Sources: Gaussian, paper, eq. 1; exponential, the closure of rough contact mu/mu0 = exp(-u/sigma) (physics/rough_contact
has its parameters); threshold, intermittent contact that begins once the plate leaves the skin (form assumed)."""
