"""The analogue filter behind the streaming index: poles and zeros whose gain is 1 / x_th(f), fitted once.

The threshold table has kinks at its points; a rational gain is smooth and stays within 0.44 dB of it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.perception.thresholds import HIGHEST_HZ, LOWEST_HZ
from frictionloop.quantities.checks import Array

Complex = NDArray[np.complex128]

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
