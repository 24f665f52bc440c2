"""The numbers of `force_observer`: the believed plant stepped over a period, and its Kalman gains."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.control.force_observer import ObserverGains, ObserverState
from frictionloop.parameters.controller import LONGEST_DELAY, Observing
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.parameters import Model

LARGEST_REST = 2.0
"""Largest |d| over the believed f0 (assumed: a finger with three times the believed friction, without vibration)."""
SPRINGS = ("x1", "x2")


def observer_gains(controller: Observing) -> ObserverGains:
    """Return the gains of `observe_step` and `predict_step` for what a controller believes.

    Disturbance and noise are given by their ratio: with q and n the densities of d' (N^2/s) and of the reading's noise
    (N^2 s), ``bandwidth_hz`` = sqrt(q/n)/2pi, the corner d would be followed with, were the sensor without lag.

    Raises
    ------
    FrictionloopError
        When no observer settles.
    """
    periods = controller.delay_s * controller.rate_hz
    return _gains(controller.model, controller.rate_hz, periods, controller.bandwidth_hz)


def observer_start(controller: Observing) -> ObserverState:
    """Return the state before the first reading: the plate is at rest, so each command so far was f0."""
    high, under_way = controller.model.nominal_n, LONGEST_DELAY + 1
    still = len(ObserverState._fields) - 2 - under_way
    return ObserverState(high, high, *[0.0] * still, *[high] * under_way)


def believed_rates(model: Model) -> tuple[list[str], np.ndarray]:
    """Return the believed states' names and their rates in 1/s, dx/dt = rates [x, c, d]; no resonance, no springs."""
    names = ["p", *(SPRINGS if model.resonance_hz > 0 else ()), "x3"]
    at = {name: i for i, name in enumerate([*names, "c", "d"])}
    rates = np.zeros((len(names), len(at)))
    plate, pole, omega = (2.0 * math.pi * hz for hz in (model.plate_hz, model.sensor_hz, model.resonance_hz))
    rates[0, [at["p"], at["c"]]] = -plate, plate
    rates[-1, at["x3"]] = -pole
    if model.resonance_hz > 0:
        rates[1, at["x2"]] = omega
        rates[2, [at["p"], at["d"], at["x1"], at["x2"]]] = omega, omega, -omega, -omega / model.resonance_q
        rates[-1, at["x1"]] = pole
    else:
        rates[-1, [at["p"], at["d"]]] = pole
    return names, rates


@lru_cache(maxsize=1024)
def _gains(model: Model, rate_hz: float, periods: float, bandwidth_hz: float) -> ObserverGains:
    whole = math.floor(periods + 1e-9)  # as the simulator rounds
    rest = periods - whole if periods - whole > 1e-9 else 0.0
    names, rates = believed_rates(model)
    entries = _stepped(names, rates / rate_hz, rest)
    found = entries | correcting_gains(names[1:], entries, bandwidth_hz / rate_hz)
    found |= {"whole": whole, "inverse": 1.0 / (1.0 - entries["pp"]), "limit": LARGEST_REST * model.nominal_n}
    return ObserverGains(*(float(found.get(name, 0.0)) for name in ObserverGains._fields))


def _stepped(names: list[str], rates: np.ndarray, rest: float) -> dict[str, float]:
    """Return the entries of the step over one period, rates per period, the command changing after ``rest`` of it."""
    from scipy.linalg import expm

    size = len(names)
    square = np.zeros((size + 2, size + 2))
    square[:size] = rates
    early, late = (expm(square * span)[:size] for span in (rest, 1.0 - rest))
    onwards, new = late[:, :size], late[:, size]
    step = np.column_stack([onwards @ early, new])
    step[:, size + 1] += late[:, size + 1]
    columns = [*(name.removeprefix("x") for name in names), "o", "d", "n"]
    return {row + column: float(step[i, j]) for i, row in enumerate(names) for j, column in enumerate(columns)}


def correcting_gains(names: list[str], entries: dict[str, float], bandwidth: float) -> dict[str, float]:
    """Return the gains that correct x1, x2, x3 and d by the error of a reading, in the steady state.

    ``bandwidth`` is in turns per period. p follows from the commands and has no gain.
    """
    size = len(names)
    transition, noise, reading = np.eye(size + 1), np.zeros((size + 1, size + 1)), np.eye(1, size + 1, size - 1)
    for i, row in enumerate(names):
        transition[i] = [*(entries[row + column.removeprefix("x")] for column in names), entries[row + "d"]]
    noise[size, size] = (2.0 * math.pi * bandwidth) ** 2
    try:
        gains = kalman_gains(transition, reading, noise, 1.0)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise FrictionloopError(
            f"controller.bandwidth_hz: no observer settles for this controller.model ({error}); "
            "bandwidth, plate_hz, sensor_hz and resonance_hz must be within a few decades of controller.rate_hz"
        ) from None
    return {"k" + name.removeprefix("x"): float(gain) for name, gain in zip([*names, "d"], gains, strict=True)}


def kalman_gains(transition: np.ndarray, reading: np.ndarray, driven: np.ndarray, noise: float) -> np.ndarray:
    """Return the stationary gains on the error of a reading, one per state.

    Riccati equation of the prediction's covariance: Anderson & Moore, Optimal Filtering (1979), ch. 4.

    Parameters
    ----------
    transition, driven
        Step of the states, and the covariance of what drives them in a period.
    reading
        States to reading, shape (1, states).
    noise
        Variance of a reading.
    """
    from scipy.linalg import solve_discrete_are

    spread = solve_discrete_are(transition.T, reading.T, driven, [[noise]])
    return np.asarray(spread @ reading.T / (reading @ spread @ reading.T + noise)).ravel()
