"""The numbers of the tracker: the believed sensor stepped over a period, and the schedule as slopes."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from frictionloop.control.law import clamp_of
from frictionloop.control.observer_gains import kalman_gains
from frictionloop.control.tracker_state import (
    Column,
    ScheduleColumns,
    SensorStep,
    TrackerGains,
    TrackerState,
    TrackerTick,
)
from frictionloop.parameters.timing import Model
from frictionloop.parameters.tracking import PLACES, Schedule, TrackerController
from frictionloop.quantities import FrictionloopError

STUCK_NOISE_N, STUCK_STEP_N = 1e-4, 1e-3
"""Noise of a reading, and what friction that sticks may do in a period beyond a steady slope (assumed)."""


def tracker_gains(controller: TrackerController) -> TrackerTick:
    """Return the gains of `tracker_step` for what a controller believes.

    Raises
    ------
    FrictionloopError
        For a model without resonance.
    """
    c, model, dt = controller, observed(controller), 1.0 / controller.rate_hz
    rest = min(c.delay_s * c.rate_hz, 1.0)
    plate = -2.0 * math.pi * model.plate_hz * dt
    own = TrackerGains(
        rest=rest,
        decay_rest=math.exp(plate * rest),
        decay_left=math.exp(plate * (1.0 - rest)),
        decay=math.exp(plate),
        inverse=-1.0 / math.expm1(plate),
        largest_um=model.max_amplitude_um,
        largest_compliance=c.largest_compliance_um_per_n,
        learn_c=c.compliance_learning,
        learn_t=c.susceptibility_learning,
        load_exponent=c.load_exponent,
        load_gain=-math.expm1(-2.0 * math.pi * c.load_hz * dt),
        skin=c.skin_stiffness_n_m,
        jump=c.largest_jump_n,
        log2_nominal=math.log2(model.nominal_n),
        model_fall=model.susceptibility_per_um2 / math.log(2.0),
        **_stuck_gains(model, c.rate_hz),
    )
    return TrackerTick(own, sensor_step_of(model, dt), slopes_of(c.schedule), *clamp_of(c.model))


def tracker_start(controller: TrackerController) -> TrackerState:
    """Return the state before the first reading: the finger that the model describes, nothing measured yet."""
    model = controller.model
    known = {
        "limit": math.log2(model.nominal_n),
        "trusted": math.log2(model.nominal_n),
        "compliance": controller.compliance_um_per_n,
        "fall": model.susceptibility_per_um2 / math.log(2.0),
    }
    return TrackerState(*(known.get(name, 0.0) for name in TrackerState._fields))


def observed(controller: TrackerController) -> Model:
    """Return the model with the resonance that the observer is given: lower and broader than it is."""
    model = controller.model
    lower = model.resonance_hz * controller.resonance_share
    return model.model_copy(update={"resonance_hz": lower, "resonance_q": controller.broadened_q})


@lru_cache(maxsize=64)
def sensor_matrices(model: Model, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A, b0, b1 of springs (force, rate over the angular frequency) and pole for a force linear over dt."""
    from scipy.linalg import expm

    if model.resonance_hz <= 0:
        raise FrictionloopError(
            "controller.model.resonance_hz = 0 Hz: a tracker needs the resonance of the force sensor, above 0"
        )
    omega, pole = 2.0 * math.pi * model.resonance_hz, 2.0 * math.pi * model.sensor_hz
    rates = np.zeros((5, 5))
    rates[:3, :3] = [[0.0, omega, 0.0], [-omega, -omega / model.resonance_q, 0.0], [pole, 0.0, -pole]]
    rates[1, 3], rates[3, 4] = omega, 1.0 / dt
    stepped = expm(rates * dt)
    return stepped[:3, :3], stepped[:3, 3] - stepped[:3, 4], stepped[:3, 4]


def sensor_step_of(model: Model, dt: float) -> SensorStep:
    """Return the same as the numbers of `sensor_step`."""
    a, b0, b1 = sensor_matrices(model, dt)
    return SensorStep(*(float(x) for x in (a[0, 0], a[0, 1], a[1, 0], a[1, 1], *a[2], *b0, *b1)))


def slopes_of(schedule: Schedule) -> ScheduleColumns:
    """Return each column of a schedule as its first value and slopes that add up."""
    values = np.array(schedule, dtype=float)
    slopes = np.diff(values, axis=0) / np.diff(PLACES)[:, None]
    columns = np.vstack([values[:1], slopes[:1], np.diff(slopes, axis=0)]).T
    return ScheduleColumns(*(Column(*column) for column in columns.tolist()))


@lru_cache(maxsize=64)
def _stuck_gains(model: Model, rate_hz: float) -> dict[str, Any]:
    """Return the stationary Kalman gains for a force of which nothing is known but that it moves on steadily."""
    a, b0, b1 = sensor_matrices(model, 1.0 / rate_hz)
    whole = np.zeros((5, 5))
    whole[:2, :2] = [[1.0, 1.0], [0.0, 1.0]]
    whole[2:, 2:], whole[2:, 0], whole[2:, 1] = a, b0 + b1, b1
    driven = np.diag([STUCK_STEP_N**2, (1e-2 * STUCK_STEP_N) ** 2, 1e-14, 1e-14, 1e-14])
    gains = kalman_gains(whole, np.eye(1, 5, 4), driven, STUCK_NOISE_N**2)
    names = ("stuck_friction", "", "stuck_spring", "stuck_rate", "stuck_reading")
    return {name: float(gain) for name, gain in zip(names, gains, strict=True) if name}
