"""A control law that observes the friction limit: its parameters, and the gains that they make of control/limit_step.

Gains are those of the believed contact and sensor for small signals. Over the mean force, with delta = ln L and phi the
friction, both as deviations, t in periods and T the contact's time constant in periods:

    delta' = w,  phi' = (delta - phi)/T,  x1' = w0 x2,  x2' = w0 (phi - x1 - x2/Q) + n w_s,  x3' = wc (x1 - x3)

w, w_s white with the same density, (2 pi bandwidth dt)^2 of the reading's noise; n is ``spring_noise``. A slider has
T = 0, where phi is delta.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from frictionloop.control.law import Law, clamp_of
from frictionloop.control.limit_observer_step import LONGEST, LimitGains, LimitState, limit_observer_step
from frictionloop.parameters import SuspendedSensor
from frictionloop.parameters.block import Number
from frictionloop.parameters.controller import Timing
from frictionloop.quantities import FrictionloopError
from frictionloop.sensing.force_sensor import suspension_coefficients

if TYPE_CHECKING:
    from frictionloop.parameters import Model

TO_ALL = np.array([[1.0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
"""From delta, x1, x2, x3 of a slider to delta, phi, x1, x2, x3."""
MOST_MARGIN = 10.0
"""Largest margin on the susceptibility (assumed)."""


class LimitObserverController(Timing):
    """Observer of the friction limit's logarithm (control/limit_step)."""

    kind: Literal["limit_observer"] = "limit_observer"
    slip_length_um: Annotated[Number, Field(ge=0, le=1000)] = 11.5
    """Believed way over which friction follows its limit, at every force; 0 is a slider (Balasubramanian, Pool &
    Vardar 2025, arXiv 2505.11162: friction's cutoff rises 13.8 Hz per mm/s, 1/(2 pi z))."""
    susceptibility_margin: Annotated[Number, Field(ge=0.1, le=MOST_MARGIN)] = 2.0
    """Believed susceptibility over the model's: the loop gain is 1 on a finger so much more susceptible.

    2 is exp(2 x 0.35): one finger of forty has more, if ln tau has the standard deviation that is assumed of it
    (physics/fingers).
    """
    bandwidth_hz: Annotated[Number, Field(gt=0, le=1e6)] = 80000.0
    """Ratio of what drives the limit to the reading's noise, as a frequency, for a force of 1 N: with q and n the
    densities of delta' (1/s) and of the noise (1/Hz), sqrt(q/n)/2pi, the corner were the sensor without lag."""
    spring_noise: Annotated[Number, Field(gt=0, le=100)] = 0.5
    """What drives the springs beside friction, over what drives the limit: the more, the less springs are trusted."""

    @property
    def overdrive(self) -> bool:
        """The amplitude command always overshoots so that the plate gets there in one period."""
        return True

    def _check(self) -> None:
        if self.delay_s * self.rate_hz > 1.0 + 1e-9:
            raise ValueError(f"delay_s = {self.delay_s:g} s: at most one period, {1.0 / self.rate_hz:g} s")


def limit_observer_gains(controller: LimitObserverController) -> LimitGains:
    """Return the gains of `limit_observer_step`.

    Raises
    ------
    FrictionloopError
        For a model without resonance, or one for which no observer settles.
    """
    c, model, dt = controller, controller.model, 1.0 / controller.rate_hz
    rest, plate = min(c.delay_s * c.rate_hz, 1.0), -2.0 * math.pi * model.plate_hz * dt
    quick, slow = limit_rows(model, c.rate_hz, c.bandwidth_hz, c.spring_noise)
    more, fall = (slow - quick) / LONGEST, model.susceptibility_per_um2 / math.log(2.0)
    springs = suspension_coefficients(
        SuspendedSensor(resonance_hz=model.resonance_hz, q=model.resonance_q, cutoff_hz=model.sensor_hz), dt
    )
    return LimitGains(
        math.exp(plate * rest), math.exp(plate * (1.0 - rest)),
        springs.a11, springs.a12, springs.a21, springs.a22, springs.a31, springs.a32, springs.a33,
        quick[0], more[0], more[1], quick[2], more[2], quick[3], more[3], quick[4], more[4],
        c.slip_length_um, model.max_amplitude_um, c.susceptibility_margin * fall,
        math.log2(model.nominal_n), fall, *clamp_of(model),
    )  # fmt: skip


def limit_observer_start(controller: LimitObserverController) -> LimitState:
    """Return the state before the first reading: no vibration, and the believed limit."""
    return LimitState(0.0, 0.0, math.log2(controller.model.nominal_n), *[0.0] * 5)


@lru_cache(maxsize=1024)
def limit_rows(model: Model, rate_hz: float, bandwidth_hz: float, spring_noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the gains of ln L, f, x1, x2, x3 for a slider, and for a contact that lags by `LONGEST` periods.

    Raises
    ------
    FrictionloopError
        For a model without resonance, or one for which no observer settles.
    """
    if model.resonance_hz <= 0.0:
        raise FrictionloopError("controller.model.resonance_hz = 0 Hz: must be above 0")
    try:
        return tuple(_row(model, rate_hz, lag, bandwidth_hz, spring_noise) for lag in (0.0, LONGEST))  # type: ignore[return-value]
    except (np.linalg.LinAlgError, ValueError) as error:
        raise FrictionloopError(
            f"controller.bandwidth_hz, controller.spring_noise: no observer settles ({error})"
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


def kalman_gains(transition: np.ndarray, reading: np.ndarray, driven: np.ndarray, noise: float) -> np.ndarray:
    """Return the stationary gains on the error of a reading, one per state.

    States take the step ``transition`` and are driven by a covariance ``driven`` in a period; ``reading``, of shape
    (1, states), makes a reading of them, with ``noise`` as its variance. Riccati equation of the prediction's
    covariance: Anderson & Moore, Optimal Filtering (1979), ch. 4.
    """
    from scipy.linalg import solve_discrete_are

    spread = solve_discrete_are(transition.T, reading.T, driven, [[noise]])
    return np.asarray(spread @ reading.T / (reading @ spread @ reading.T + noise)).ravel()


LAW = Law("limit_observer", limit_observer_step, LimitState, LimitGains, limit_observer_gains, limit_observer_start)
