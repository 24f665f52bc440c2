"""A shaping filter of low order from a measured spectrum: a falling background and one peak, in one filter."""

from __future__ import annotations

import math

import numpy as np

from frictionloop.analysis.state_space import Array, Complex
from frictionloop.quantities import FrictionloopError, Lti

FALLS = 3
"""Real poles of the background; between them zeros, which together follow 1/f to about 1 dB over three decades."""
PER_DECADE = 20
"""Points of the spectrum per decade in the fit, so that high frequencies, which have more lines, do not rule it."""
HIGHEST_HZ = 200.0
"""Frequency up to which the fit looks: with 300 us of delay no loop attenuates above it, and it only matters as |S|."""


def fit_shaping(frequency_hz: Array, density: Array, peak: tuple[float, float]) -> tuple[Lti, float]:
    """Return H(s) with |H(j 2 pi f)|^2 nearest to a one-sided density, and the rms distance in dB over log f.

        |H|^2 = g^2 prod |1 + j f/z_i|^2 / prod |1 + j f/p_i|^2 + c^2 / ((f_0^2 - f^2)^2 + (b f)^2)

    Parameters
    ----------
    frequency_hz
        Rising frequencies in Hz, above 0.
    density
        One-sided density, above 0, unit^2/Hz.
    peak
        First guess of the peak's frequency f_0 and width b, Hz.

    Raises
    ------
    FrictionloopError
        A density that is not positive and finite, or fewer than 12 frequencies below 200 Hz.
    """
    from scipy.optimize import least_squares

    inside = frequency_hz <= HIGHEST_HZ
    if inside.sum() < 12 or not np.all(np.isfinite(density[inside]) & (density[inside] > 0)):
        raise FrictionloopError("density: needs at least 12 positive, finite values up to 200 Hz to fit a filter to")
    f, level = _thinned(frequency_hz[inside], density[inside])

    def distance(parameters: Array) -> Array:
        return np.asarray(10 * np.log10(_density(parameters, f) / level))

    corners = np.geomspace(f[0] / 2, 150.0, 2 * FALLS - 1)
    start = np.log(np.array([math.sqrt(level[0]), *corners, peak[0], peak[1], _peak_size(f, level, peak)]))
    # The spectrum says nothing below its first line: a slower pole would be made up, and stiff besides.
    least = np.full(start.size, -np.inf)
    least[1 : 2 * FALLS : 2] = math.log(f[0] / 2)
    fitted = least_squares(distance, np.maximum(start, least + 1e-3), bounds=(least, np.inf), loss="soft_l1")
    return _factor(fitted.x), float(np.sqrt(np.mean(distance(fitted.x) ** 2)))


def _thinned(frequency: Array, density: Array) -> tuple[Array, Array]:
    """Return means over equal steps of log f."""
    decades = math.log10(frequency[-1] / frequency[0])
    edges = np.geomspace(frequency[0], frequency[-1] * (1 + 1e-9), math.ceil(PER_DECADE * decades) + 1)
    which = np.digitize(frequency, edges)
    groups = [which == k for k in np.unique(which)]
    return np.array([frequency[g].mean() for g in groups]), np.array([density[g].mean() for g in groups])


def _peak_size(f: Array, level: Array, peak: tuple[float, float]) -> float:
    """Return c that gives the peak the density seen there."""
    return math.sqrt(float(np.interp(peak[0], f, level))) * peak[0] * peak[1]


def _unpack(parameters: Array) -> tuple[float, Array, Array, float, float, float]:
    gain, *corners, centre, width, size = np.exp(parameters)
    return float(gain), np.array(corners[0::2]), np.array(corners[1::2]), float(centre), float(width), float(size)


def _density(parameters: Array, f: Array) -> Array:
    gain, poles, zeros, centre, width, size = _unpack(parameters)
    background = (
        gain**2 * np.prod(1 + (f[:, None] / zeros) ** 2, axis=1) / np.prod(1 + (f[:, None] / poles) ** 2, axis=1)
    )
    return np.asarray(background + size**2 / ((centre**2 - f**2) ** 2 + (width * f) ** 2))


def _factor(parameters: Array) -> Lti:
    """Return the stable filter of minimum phase with this density: its polynomials in f^2, and their left roots."""
    gain, poles, zeros, centre, width, size = _unpack(parameters)
    # In x = f^2: 1 + x/z^2 and (x - f0^2)^2 + b^2 x.
    over = np.array([1.0, width**2 - 2 * centre**2, centre**4])
    under = _product(poles)
    num = np.polyadd(gain**2 * np.polymul(_product(zeros), over), size**2 * under)
    s = 2 * math.pi
    numerator, denominator = (
        s * _left(np.roots(num).astype(complex)),
        s * np.concatenate([-poles, _left(np.roots(over).astype(complex))]),
    )
    scale = math.sqrt(gain**2 + size**2 / centre**4)
    b, a = np.poly(numerator).real, np.poly(denominator).real
    return Lti(tuple(scale * b / b[-1]), tuple(a / a[-1]))


def _product(corners: Array) -> Array:
    product = np.ones(1)
    for corner in corners:
        product = np.polymul(product, [1 / corner**2, 1.0])
    return product


def _left(squares: Complex) -> Array:
    """Return the roots j f, f^2 given, that lie in the left half plane, Hz."""
    roots = 1j * np.sqrt(squares.astype(complex))
    return np.where(roots.real > 0, -roots, roots)
