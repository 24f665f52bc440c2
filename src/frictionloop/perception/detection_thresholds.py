"""The smallest vibration and the smallest force a fingertip feels, by frequency: x_th(f) and F_th(f)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.parameters import Skin
from frictionloop.quantities import Array, FrictionloopError
from frictionloop.quantities.value_checks import numbers

LOWEST_HZ, HIGHEST_HZ = 1.0, 500.0
"""The range of the threshold table, and so of the index D."""
THRESHOLD_UM = {
    1.0: 25.0,
    3.0: 20.0,
    5.0: 16.0,
    10.0: 10.0,
    20.0: 6.0,
    30.0: 4.0,
    40.0: 2.5,
    60.0: 1.2,
    80.0: 0.7,
    100.0: 0.4,
    150.0: 0.18,
    200.0: 0.12,
    250.0: 0.10,
    300.0: 0.11,
    400.0: 0.18,
    500.0: 0.30,
}
"""Displacement threshold by frequency in Hz, um zero-to-peak, +-6 dB (Bolanowski and Verrillo; from memory)."""


def impedance(finger: Skin) -> tuple[float, float, float]:
    """Return k in N/m, c in N s/m and m in kg of Z(f) = k - w^2 m + j w c, refusing what has none, or no damping."""
    if not (isinstance(finger, Skin) and finger.damping_n_s_m > 0):
        raise FrictionloopError(f"finger = {finger!r}: must be a damped Skin")
    return finger.stiffness_n_m, finger.damping_n_s_m, finger.mass_kg


def displacement_threshold_um(frequency_hz: ArrayLike) -> Array:
    """Return x_th(f), the smallest sinusoidal vibration felt, in um zero-to-peak.

    Straight lines between the points of `THRESHOLD_UM` in log x_th over log f; +-6 dB.

    Parameters
    ----------
    frequency_hz
        Frequencies in Hz, 1 to 500, of any shape.

    Raises
    ------
    FrictionloopError
        For a frequency that is not a number or outside the table.
    """
    frequency = numbers("frequency_hz", frequency_hz, "Hz", LOWEST_HZ, HIGHEST_HZ)
    return np.asarray(np.exp(np.interp(np.log(frequency), _LOG_HZ, _LOG_UM)))


def force_threshold_n(frequency_hz: ArrayLike, finger: Skin | None = None) -> Array:
    """Return F_th(f) = x_th(f) |k - w^2 m + j w c|, the force that moves the skin by x_th, in N zero-to-peak.

    From 25 mN at 1 Hz to 0.17 mN at 250 Hz with the default fingertip. The paper (Sec. 2.3, after its ref. [14])
    takes 0.5 mN for all frequencies.

    Parameters
    ----------
    frequency_hz
        Frequencies in Hz, 1 to 500, of any shape.
    finger
        The fingertip; None is a `Skin` as it is.

    Raises
    ------
    FrictionloopError
        For a frequency outside the table, or a finger without damping.
    """
    k, c, m = impedance(finger or Skin())
    omega = 2 * math.pi * numbers("frequency_hz", frequency_hz, "Hz", LOWEST_HZ, HIGHEST_HZ)
    return 1e-6 * displacement_threshold_um(frequency_hz) * np.hypot(k - omega**2 * m, omega * c)


_LOG_HZ = np.log(list(THRESHOLD_UM))
_LOG_UM = np.log(list(THRESHOLD_UM.values()))
