"""The linear controller of least variance around a plant that is known and stable: Wiener and Hopf, by FFT.

Every stabilising controller of such a plant is made of one stable, causal transfer function (Youla, Jabr, Bongiorno,
"Modern Wiener-Hopf design of optimal controllers, part II", IEEE Trans. Autom. Control 21, 1976). Here that is X, what
the command is made of over the plant's poles, so that with N_y and N_f the numerators to reading and friction
S = 1 - N_y X, and sensor noise comes to friction as N_f X.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.quantities import Array, Complex

FLOOR = 1e-14
"""Least of the spectrum that is factored, over its largest: its logarithm has to be finite."""


class Spectra(NamedTuple):
    """The bins 0, 1, ..., M of an FFT over 0 to the Nyquist frequency, and what is there; each shape (M + 1,)."""

    width_hz: Array
    """Width of a bin; those at both ends are half."""
    disturbance: Array
    """One-sided density, N^2/Hz."""
    noise: Array
    """One-sided density of the reading's noise, N^2/Hz."""
    reading: Complex
    """N_y."""
    friction: Complex
    """N_f."""
    drive: Array
    """Density of the command over |X|^2, N^2/Hz: |A|^2 (|N_y/N_f|^2 Phi_d + Phi_n), A the poles."""
    price: float = 0.0
    """What a square of the command costs, over that of the residual."""

    def heard(self) -> Array:
        """Return |N_f|^2 Phi_n, the density that a choice of X lets through times |X|^2."""
        return squared(self.friction) * self.noise

    def paid(self) -> Array:
        """Return the same with what the command costs."""
        return self.heard() + self.price * self.drive


def squared(response: Complex) -> Array:
    """Return |.|^2, without the root that numpy's abs takes."""
    return np.asarray(response.real**2 + response.imag**2)


def bins(
    frequency_hz: Array,
    disturbance: Array,
    noise: Array,
    nyquist_hz: float,
    paths: tuple[ArrayLike, ArrayLike, ArrayLike],
    size: int,
) -> Spectra:
    """Return densities given in bands (as for `waterbed_bound`) as ``size`` bins of the same power, for N_y, N_f, A."""
    frequencies = np.linspace(0.0, nyquist_hz, size + 1)
    edges, bands = _edges(frequencies, nyquist_hz), _edges(frequency_hz, nyquist_hz)
    width = np.diff(edges)

    def spread(density: Array) -> Array:
        below = np.concatenate([[0.0], np.cumsum(np.diff(bands) * density)])
        return np.asarray(np.diff(np.interp(edges, bands, below)) / width)

    back = np.exp(-1j * np.pi * frequencies / nyquist_hz)
    reading, friction, poles = (np.polynomial.polynomial.polyval(back, np.asarray(path, dtype=float)) for path in paths)
    moved, heard = spread(disturbance), spread(noise)
    sensor = squared(reading) / np.maximum(squared(friction), np.finfo(float).tiny)
    return Spectra(width, moved, heard, reading, friction, squared(poles) * (sensor * moved + heard))


def _edges(frequency_hz: Array, nyquist_hz: float) -> Array:
    return np.concatenate([[0.0], (frequency_hz[1:] + frequency_hz[:-1]) / 2.0, [nyquist_hz]])


def causal_factor(square: Array) -> Complex:
    """Return M with |M|^2 = ``square``, M and 1/M causal: the exponential of the causal part of ln|M|, by its cepstrum.

    Oppenheim, Schafer, Discrete-Time Signal Processing, ch. 13.
    """
    size = square.size - 1
    cepstrum = np.fft.irfft(0.5 * np.log(np.maximum(square, FLOOR * float(np.max(square)))), 2 * size)
    cepstrum[1:size] *= 2.0
    cepstrum[size + 1 :] = 0.0
    return np.asarray(np.exp(np.fft.rfft(cepstrum)))


def least_power(spectra: Spectra, weight: Array | float = 0.0, target: Complex | float = 1.0) -> tuple[float, Complex]:
    """Return the least of integral |T - N_y X|^2 (Phi_d + weight) + |X|^2 Q over all stable, causal X, and this X.

    Q = |N_f|^2 Phi_n + price * drive; with a target T of 1 the first is |S|^2. With M M* = |N_y|^2 W + Q,
    W = Phi_d + weight, M and 1/M causal, and R = W T N_y*/M*, the integrand is |T|^2 W Q/|M|^2 + |M X - R|^2: M X has
    to be the causal part of R, and the square of the rest is left.
    """
    size = spectra.width_hz.size - 1
    whole, gain = spectra.disturbance + weight, squared(spectra.reading)
    square = whole * gain + spectra.paid()
    square = np.maximum(square, FLOOR * float(np.max(square)))
    factor = causal_factor(square)
    wanted = np.fft.irfft(whole * target * np.conj(spectra.reading / factor), 2 * size)
    behind = float(np.sum(wanted[size:] ** 2)) * float(np.sum(spectra.width_hz))
    wanted[size:] = 0.0
    hidden = whole * (1.0 - whole * gain / square) * squared(np.asarray(target))
    return float(spectra.width_hz @ hidden) + behind, np.asarray(np.fft.rfft(wanted) / factor)
