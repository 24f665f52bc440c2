"""Spectrum of a slide: band powers, the exponent of a power law, and what two signals have in common."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq
from scipy.signal import detrend

from frictionloop.quantities import FrictionloopError

HANN_INFLATION = 35.0 / 18.0
"""Variance of a sum of Hann periodogram ordinates over that of independent ones: 1 + 2 (2/3)^2 + 2 (1/6)^2."""
EDGE = 1e-6
"""How far outside a band, relative, a frequency still counts: sampling rates are rounded."""
ROUNDING = 1e-12
"""Relative size below which a variation is rounding."""
STEEPEST = 20.0
"""Largest exponent that is looked for, either sign."""


def inside(frequency: np.ndarray, band_hz: tuple[float, float]) -> np.ndarray:
    """Return which frequencies lie in a band, both ends included."""
    low, high = band_hz
    return np.asarray((frequency >= low * (1.0 - EDGE)) & (frequency <= high * (1.0 + EDGE)))


def waves_of(values: np.ndarray) -> np.ndarray:
    """Return complex amplitudes whose squared moduli add up to the variance: a Hann periodogram with its phases.

    The line through the values is taken out first; what rounding leaves of a line counts as none.
    """
    hann = np.sin(np.pi * np.arange(values.size) / values.size) ** 2
    scale = math.sqrt(2.0 / (values.size * float(hann @ hann)))
    left = detrend(values)
    left *= np.abs(left).max() > ROUNDING * np.abs(values).max()
    return np.asarray(scale * np.fft.rfft(hann * left))


def band_rms(frequency: np.ndarray, waves: np.ndarray, band_hz: tuple[float, float]) -> float:
    """Return the standard deviation that a band contributes."""
    return float(np.linalg.norm(waves[inside(frequency, band_hz)]))


def power_law(name: str, frequency: np.ndarray, waves: np.ndarray, band_hz: tuple[float, float]) -> tuple[float, float]:
    """Return p of S = A f^-p in a band, by Whittle's likelihood, and its standard error.

    p minimises ln mean(S f^p) - p mean(ln f), which is convex, so that its derivative has one zero. The error is
    sqrt((35/18) / sum (ln f - mean ln f)^2), 35/18 for the correlation that the Hann window makes between neighbours.

    Parameters
    ----------
    name : str
        What the values are, for the error.
    frequency, waves : array
        Frequencies in Hz and `waves_of`, shape (frequencies,).
    band_hz : tuple
        Lowest and highest frequency, the lowest above 0.

    Notes
    -----
    P. Whittle, Arkiv foer Matematik 2 (1953) 423.
    """
    keep = inside(frequency, band_hz)
    density, log_f = np.abs(waves[keep]) ** 2, np.log(frequency[keep])
    if not density.max() > 0:
        raise FrictionloopError(f"recording: {name!r} does not vary within {band_hz[0]:g} to {band_hz[1]:g} Hz")
    log_f -= log_f.mean()

    def derivative(p: float) -> float:
        weight = density * np.exp(p * log_f - abs(p) * np.abs(log_f).max())
        return float(weight @ log_f / weight.sum())

    return float(brentq(derivative, -STEEPEST, STEEPEST)), math.sqrt(HANN_INFLATION / float(log_f @ log_f))


def in_common(waves: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Return correlation and regression slope of waves on others of the same frequencies; 0, 0 if either is still."""
    power, other_power = float(np.linalg.norm(waves)), float(np.linalg.norm(other))
    both = float(np.sum((waves * other.conj()).real))
    if power == 0.0 or other_power == 0.0:
        return 0.0, 0.0
    return both / (power * other_power), both / other_power**2
