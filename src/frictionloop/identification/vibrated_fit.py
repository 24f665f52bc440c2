"""How friction may fall with the amplitude, and one such law fitted to pieces of a finger, with moisture and load."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from frictionloop.identification.sliding_pieces import Pieces

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
    VibratedLaw("exponential", "exp(-a/a1): rough contact", _exponential, (1.0,), (-5.0,), (50.0,)),
    VibratedLaw("threshold", "1 up to a0, then linear", _threshold, (1.0, 0.2), (0.0, 0.0), (20.0, 0.95)),
)
"""x[0] is the exponent at the largest amplitude (of the threshold law the slope there), so of the order of 1 for all.

Sources: Gaussian, paper, eq. 1; exponential, the closure of rough contact mu/mu0 = exp(-u/sigma) (physics/rough_contact
has its parameters); threshold, intermittent contact that begins once the plate leaves the skin (form assumed)."""


REFERENCE_LOAD_N = 0.5
"""Load that f0 is told for, that of `bench` (assumed there)."""
PRIORS = {
    "load": (0.85, 0.2),
    "occlusion": (1.0, 3.0),
    "loss": (0.15, 0.3),
    "log_time": (math.log(20.0), math.log(2.0)),
}
"""Middle and width of what is known beforehand, which decides where a recording says nothing: load exponent (2/3 to 1
on smooth glass: Dzidek 2014), growth of the friction in contact (up to 10 times: Adams 2013), share of tau that
moisture takes (direction: Gueorguiev 2017; width assumed), logarithm of the time in s in which moisture builds up
(20 s: Pasumarty 2011, paper ref. [9]; width assumed)."""
FIXED = 5


class LawFit(NamedTuple):
    """One law, fitted."""

    name: str
    words: str
    aic: float
    """N log(S/N) - segments log(1 - rho^2) + 2k, S the sum of squares less what one residual tells of the next."""
    x: tuple[float, ...]
    """log f0 at 0.5 N, exponent of the load, growth in contact, share of the effect lost to moisture, log of the time
    in which that happens, the law's own."""
    residual: float
    """rms of what is left of log friction."""
    carried: float
    """Correlation rho of neighbouring residuals."""


def wet_share(contact_s: Array, log_time: float) -> Array:
    """Return w = 1 - exp(-t/T), how far moisture has built up in contact."""
    return np.asarray(-np.expm1(-contact_s / math.exp(log_time)))


def relative_load(pieces: Pieces) -> Array:
    """Return log(N/0.5 N) of each piece."""
    return np.asarray(pieces.log_load - np.log(REFERENCE_LOAD_N))


def fit_law(law: VibratedLaw, pieces: Pieces, largest_um: float) -> tuple[LawFit, Array, float]:
    """Return a law's fit, the standard errors of its parameters, and their degrees of freedom."""
    relative, count = relative_load(pieces), pieces.contact_s.size
    middles, widths = np.array(list(PRIORS.values())).T
    known = np.arange(1, FIXED)

    def left(x: Array) -> Array:
        wet = wet_share(pieces.contact_s, x[4])
        exponent = law.exponent(pieces.amplitude_um, x[FIXED:], largest_um)
        share = np.log(np.mean(np.exp(-exponent * (1 - x[3] * wet)[:, None]), axis=1))
        return np.asarray(pieces.log_friction - x[0] - x[1] * relative - np.log1p(x[2] * wet) - share)

    def whitened(x: Array, rho: float, sigma: float) -> Array:
        r = left(x)
        first = np.sqrt(1 - rho**2) * r
        rows = np.where(pieces.follows, r - rho * np.concatenate([[0.0], r[:-1]]), first)
        return np.concatenate([rows, sigma * (x[known] - middles) / widths])

    x = np.array([float(np.mean(pieces.log_friction)), *middles, *law.start])
    low = np.array([-np.inf, -2.0, -0.95, -1.0, 0.0, *law.low])
    high = np.array([np.inf, 4.0, 30.0, 0.95, 6.0, *law.high])
    rho, sigma = 0.0, 0.1
    for _ in range(3):
        fit = least_squares(whitened, x, args=(rho, sigma), bounds=(low, high), x_scale=0.1, ftol=1e-6, xtol=1e-6)
        x, r = fit.x, left(fit.x)
        both = pieces.follows[1:]
        rho = float(np.clip(np.sum((r[1:] * r[:-1])[both]) / max(np.sum((r[:-1] ** 2)[both]), 1e-300), 0.0, 0.98))
        squares = float(np.sum(whitened(x, rho, sigma)[:count] ** 2))
        sigma = max(float(np.sqrt(squares / count)), 1e-9)
    freedom = max(count * (1 - rho) / (1 + rho) - x.size, 1.0)
    errors = sigma * np.sqrt(np.diag(np.linalg.pinv(fit.jac.T @ fit.jac)))
    segments = int(np.count_nonzero(~pieces.follows))
    aic = count * np.log(squares / count) - segments * np.log(1 - rho**2) + 2 * (x.size + 2)
    rms = float(np.sqrt(np.mean(r**2)))
    return LawFit(law.name, law.words, float(aic), tuple(x.tolist()), rms, rho), errors, freedom
