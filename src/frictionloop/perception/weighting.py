"""The index D without storing a trace: a filter of gain 1 / F_th(f), so that D is the rms of the filtered residual.

The analogue filter behind the streaming index: poles and zeros whose gain is 1 / x_th(f), fitted once.

The threshold table has kinks at its points; a rational gain is smooth and stays within 0.44 dB of it.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from frictionloop.parameters import Skin
from frictionloop.perception.detection_thresholds import HIGHEST_HZ, LOWEST_HZ, force_threshold_n, impedance
from frictionloop.quantities import Array, Complex, FrictionloopError
from frictionloop.quantities.value_checks import number

HIGHPASS_HZ = 0.7
"""Corner of the second-order Butterworth high-pass that keeps mean and drift out, 0.9 dB down at 1 Hz (assumed)."""
GRID_HZ = np.geomspace(LOWEST_HZ, HIGHEST_HZ, 400)
"""Where the gain is compared with the table: evenly spaced in log f."""


class Prototype(NamedTuple):
    """G(s) = gain s^2 / B(s) prod Q_zeros(s) / prod Q_poles(s), Q = 1 + 2 zeta s/w + (s/w)^2, B the high-pass."""

    gain_per_um: float
    """Gain between the high-pass and the first zero, 1/um."""
    zeros: tuple[tuple[float, float], ...]
    """Frequency w / 2 pi in Hz and damping ratio zeta of each pair."""
    poles: tuple[tuple[float, float], ...]
    """The same of the poles."""


PROTOTYPE = Prototype(
    gain_per_um=0.0427743,
    zeros=((4.59950, 0.948633), (28.5841, 0.781175)),
    poles=((9.26504, 1.13138), (187.647, 0.592466), (297.210, 0.434460)),
)
"""A least-squares fit, rounded: 0.11 dB rms and 0.43 dB at most from the table, 1 to 500 Hz."""


def gain_db(prototype: Prototype, frequency_hz: Array) -> Array:
    """Return 20 log10 |G(j 2 pi f)|, G in 1/um, for positive frequencies in Hz of any shape."""
    ratio = np.asarray(HIGHPASS_HZ / frequency_hz) ** 4
    power = prototype.gain_per_um**2 / (1 + ratio) * np.ones_like(ratio)
    for pairs, sign in ((prototype.zeros, 1), (prototype.poles, -1)):
        for corner_hz, damping in pairs:
            x2 = (np.asarray(frequency_hz) / corner_hz) ** 2
            power = power * ((1 - x2) ** 2 + 4 * damping**2 * x2) ** sign
    return np.asarray(10 * np.log10(power))


def roots_of(corner_hz: float, damping: float) -> Complex:
    """Return the two roots of 1 + 2 zeta s/w + (s/w)^2 in rad/s; without cancellation when they are real."""
    omega = 2 * math.pi * corner_hz
    if damping > 1:
        far = -omega * (damping + math.sqrt(damping**2 - 1))
        return np.array([omega**2 / far, far], dtype=complex)
    return omega * (-damping + 1j * math.sqrt(1 - damping**2) * np.array([1, -1]))


RATES_HZ = (1200.0, 200_000.0)
"""Sampling rates that the filter is made for."""
ERROR_DB = 0.45
"""Largest distance between the filter's gain and 1 / F_th from 1 to 500 Hz; 0.12 dB rms over log f (tested)."""


def weighting_sos(rate_hz: float, finger: Skin | None = None) -> Array:
    """Return the filter whose gain is 1 / F_th(f) in 1/N from 1 to 500 Hz and falls off on either side.

        H(z) = gain prod (1 - z_i / z) / prod (1 - p_i / z),   D = rms of the filtered residual

    Poles and zeros are z = exp(s / rate) of the fitted `PROTOTYPE`, and of the skin 1 / (k + s c + s^2 m), which
    is exact for any finger. The skin leaves two zeros free: they take up what sampling changes of the gain, by
    linear least squares on |H|^2. Nothing is searched for: another finger costs about two milliseconds.

    Parameters
    ----------
    rate_hz
        Sampling rate in Hz, 1200 to 200 000.
    finger
        The fingertip; None is a `Skin` as it is.

    Returns
    -------
    Second-order sections as in `scipy.signal`, shape (5, 6); stable, and of minimum phase but for the two zeros at
    0 Hz, which the first section has. Computed once for the same arguments.

    Raises
    ------
    FrictionloopError
        For a rate outside the range, or a finger whose gain the filter would miss by more than 0.45 dB.
    """
    # A copy: the cached array must not change, and scipy.signal does not take a read-only one.
    return _sections(number("rate_hz", rate_hz, "Hz", *RATES_HZ), *impedance(finger or Skin())).copy()


@lru_cache(maxsize=4096)
def _sections(rate: float, k: float, c: float, m: float) -> Array:
    finger = Skin(stiffness_n_m=k, damping_n_s_m=c, mass_kg=m)
    skin = roots_of(math.sqrt(k / m) / (2 * math.pi), c / (2 * math.sqrt(k * m)))
    # A pole above half the rate would come back mirrored; the two free zeros make up for a real one just as well.
    skin = np.where(np.abs(skin.imag) < math.pi * rate, skin, -np.abs(skin))
    zeros = [np.ones(2), *(np.exp(roots_of(*pair) / rate) for pair in PROTOTYPE.zeros), np.zeros(2)]
    corners = [(HIGHPASS_HZ, math.sqrt(0.5)), *PROTOTYPE.poles]
    poles = [*(np.exp(roots_of(*pair) / rate) for pair in corners), np.exp(skin / rate)]
    sos = np.array([[*np.poly(z), *np.poly(p)] for z, p in zip([*zeros, np.zeros(2)], poles, strict=True)])
    sos[-1, :3] = _free_zeros(sos, rate, finger)
    error = _error_db(sos, rate, finger, GRID_HZ)
    if not np.abs(error).max() <= ERROR_DB:
        raise FrictionloopError(f"rate_hz = {rate:g} Hz: too low to weigh {finger}")
    return sos


def _free_zeros(sos: Array, rate: float, finger: Skin) -> Array:
    """Return b0, b1, b2 with |b|^2 = c0 + c1 x + c2 x^2, x = sin(w/2)^2, nearest to what the gain lacks."""
    k, c, m = impedance(finger)
    omega = 2 * math.pi * GRID_HZ
    wanted = 10 ** (gain_db(PROTOTYPE, GRID_HZ) / 20) * 1e6 / np.hypot(k - omega**2 * m, omega * c)
    lacking = (wanted / _gain(sos, rate, GRID_HZ)) ** 2
    x = np.sin(math.pi * GRID_HZ / rate) ** 2
    powers = np.vander(x / x[-1], 3) / lacking[:, None]  # relative, so that decibels are what is small
    c2, c1, c0 = np.linalg.lstsq(powers, np.ones_like(x), rcond=None)[0] / x[-1] ** np.array([2, 1, 0])
    zeros = _inside(np.roots([c2, c1, c0]).astype(complex))
    polynomial = np.poly(zeros).real
    # Negative c0 is a hopeless fit, which the caller refuses by its error.
    return np.asarray(polynomial * math.sqrt(abs(c0)) / polynomial.sum())


def _inside(x: Complex) -> Complex:
    """Return the z inside the unit circle at which sin(w/2)^2 = (2 - z - 1/z) / 4 is x."""
    u = 1 - 2 * x
    root = np.sqrt(u**2 - 1)
    outer = np.where(np.abs(u + root) > 1, u + root, u - root)
    return np.asarray(1 / outer)


def _gain(sos: Array, rate: float, frequency_hz: Array) -> Array:
    back = np.exp(-2j * math.pi * frequency_hz / rate)  # z^-1
    powers = np.stack([np.ones_like(back), back, back**2])
    ratios = np.tensordot(sos[:, :3], powers, 1) / np.tensordot(sos[:, 3:], powers, 1)
    return np.abs(np.prod(ratios, axis=0))


def _error_db(sos: Array, rate: float, finger: Skin, frequency_hz: Array) -> Array:
    return np.asarray(20 * np.log10(_gain(sos, rate, frequency_hz) * force_threshold_n(frequency_hz, finger)))
