"""Gains of the limit's observer: the believed contact and sensor for small signals, and its Riccati equation.

Over the mean force, with delta = ln L and phi the friction, both as deviations, t in periods and T the contact's time
constant in periods:

    delta' = w,  phi' = (delta - phi)/T,  x1' = w0 x2,  x2' = w0 (phi - x1 - x2/Q) + n w_s,  x3' = wc (x1 - x3)

w, w_s white with the same density, (2 pi bandwidth dt)^2 of the reading's noise; n is ``spring_noise``. A slider has
T = 0, where phi is delta.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.control.observer_gains import kalman_gains
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.parameters import Model

LONGEST = 7.5
"""Time constant of a contact in periods up to which gains follow it: 1.5 ms at 5 kHz, a bristle's of 0.6 N at 20 mm/s
(paper, Sec. 4.2; compliance 50 um/N)."""
TO_ALL = np.array([[1.0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
"""From delta, x1, x2, x3 of a slider to delta, phi, x1, x2, x3."""


@lru_cache(maxsize=1024)
def limit_rows(model: Model, rate_hz: float, bandwidth_hz: float, spring_noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the gains of ln L, f, x1, x2, x3 for a slider, and for a contact that lags by `LONGEST` periods.

    Raises
    ------
    FrictionloopError
        For a model without resonance, or one for which no observer settles.
    """
    if model.resonance_hz <= 0.0:
        raise FrictionloopError(
            "controller.model.resonance_hz = 0 Hz: a limit observer needs the resonance of the force sensor, above 0"
        )
    try:
        return tuple(_row(model, rate_hz, lag, bandwidth_hz, spring_noise) for lag in (0.0, LONGEST))  # type: ignore[return-value]
    except (np.linalg.LinAlgError, ValueError) as error:
        raise FrictionloopError(
            f"controller.bandwidth_hz, controller.spring_noise: no observer settles for this controller.model ({error})"
        ) from None


def believed(model: Model, rate_hz: float, lag: float) -> np.ndarray:
    """Return the rates per period of delta, phi (with a ``lag`` in periods), x1, x2, x3; of a slider without phi."""
    omega, pole = 2.0 * math.pi * model.resonance_hz / rate_hz, 2.0 * math.pi * model.sensor_hz / rate_hz
    rates = np.zeros((5, 5))
    rates[2, 3], rates[3, 1:4] = omega, [omega, -omega, -omega / model.resonance_q]
    rates[4, [2, 4]] = pole, -pole
    if lag == 0.0:
        return np.asarray((rates @ TO_ALL)[[0, 2, 3, 4]])
    rates[1, :2] = 1.0 / lag, -1.0 / lag
    return rates


def _row(model: Model, rate_hz: float, lag: float, bandwidth_hz: float, spring_noise: float) -> np.ndarray:
    from scipy.linalg import expm

    rates = believed(model, rate_hz, lag)
    size = len(rates)
    driven = np.zeros((size, size))
    driven[0, 0], driven[size - 2, size - 2] = 1.0, spring_noise**2
    # The covariance that a period adds (Van Loan 1978).
    both = expm(np.block([[-rates, driven], [np.zeros((size, size)), rates.T]]))
    transition = both[size:, size:].T
    added = transition @ both[:size, size:] * (2.0 * math.pi * bandwidth_hz / rate_hz) ** 2
    gains = kalman_gains(transition, np.eye(1, size, size - 1), (added + added.T) / 2.0, 1.0)
    return TO_ALL @ gains if size < len(TO_ALL) else gains
