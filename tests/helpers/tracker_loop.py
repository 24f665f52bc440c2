"""The tracker and its plant for small signals, its estimates right and at rest: what a row of its schedule does.

In newtons around an operating point the tracker is linear (control/limit_observer): the limit that vibration leaves is
a command of two periods ago plus the disturbance; friction goes a share of the way to it per period.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from frictionloop.analysis.state_space import Array, Complex
from frictionloop.control.tracker_gains import sensor_matrices
from frictionloop.parameters import Model

STATES = 12
LIMIT, FRICTION, SENSOR, NOW, NEXT, TRUE_FRICTION, TRUE_SENSOR, TRUSTED = 0, 1, slice(2, 5), 5, 6, 7, slice(8, 11), 11


class Row(NamedTuple):
    """One row of ``TrackerController.schedule``."""

    limit: float
    friction: float
    spring: float
    rate: float
    reading: float
    lead: float
    trust: float


@dataclass(frozen=True)
class Answer:
    """What a row does at some frequencies, on one plant."""

    sensitivity: Complex
    """S = 1/(1 + G)."""
    friction_from_noise: Complex
    limit_from_noise: Complex
    """The commanded limit."""
    radius: float
    """Largest pole; below 1 the loop is stable."""


@dataclass(frozen=True)
class Plant:
    """The sensor as it is, and how friction follows its limit."""

    sensor: Model
    share: float
    gain: float = 1.0
    """True susceptibility over the believed one."""


def observer_matrix(model: Model, share: float, dt: float) -> Array:
    """Return one period of [limit, friction, springs (2), reading] as the tracker believes it."""
    a, b0, b1 = sensor_matrices(model, dt)
    whole = np.zeros((5, 5))
    whole[0, 0], whole[1, 0], whole[1, 1] = 1.0, share, 1.0 - share
    whole[2:, 2:], whole[2:, 1] = a, b0
    whole[2:] += np.outer(b1, whole[1])
    return whole


def answer(row: Row, believed: Model, share: float, plant: Plant, z: Complex, dt: float) -> Answer:
    """Return the loop of a row at points z on the unit circle; noise enters the reading."""
    unit = np.eye(STATES)
    error = unit[TRUE_SENSOR][2] - unit[SENSOR][2]
    free, before = _tracker(row, believed, share, unit, error, dt)
    noise = np.ones(1)
    driven, _ = _tracker(row, believed, share, np.zeros((STATES, 1)), noise, dt)
    a, b0, b1 = sensor_matrices(plant.sensor, dt)
    matrix, enters = free, driven[:, 0]
    left = plant.gain * (unit[NEXT] if plant.share >= 1.0 else 0.5 * (unit[NOW] + unit[NEXT]))
    matrix[TRUE_FRICTION] = before + plant.share * (left - before)
    matrix[TRUE_SENSOR] = a @ unit[TRUE_SENSOR] + np.outer(b0, before) + np.outer(b1, matrix[TRUE_FRICTION])
    poles, vectors = np.linalg.eig(matrix)
    weights = np.linalg.solve(vectors, enters)
    resolvent = 1.0 / (z[:, None] - poles[None, :])
    read = unit[TRUE_SENSOR][2] @ vectors
    return Answer(
        sensitivity=1.0 + resolvent @ (read * weights),
        friction_from_noise=resolvent @ (vectors[TRUE_FRICTION] * weights),
        limit_from_noise=resolvent @ (vectors[NEXT] * weights),
        radius=float(np.abs(poles).max()),
    )


def _tracker(row: Row, believed: Model, share: float, x: Array, error: Array, dt: float) -> tuple[Array, Array]:
    """Return the tracker's rows of a period as maps of x, and the true friction before it."""
    a, b0, b1 = sensor_matrices(believed, dt)
    limit = x[LIMIT] + row.limit * error
    friction = x[FRICTION] + row.friction * error
    sensor = x[SENSOR] + np.outer([row.spring, row.rate, row.reading], error)
    left = limit + (x[NEXT] if share >= 1.0 else 0.5 * (x[NOW] + x[NEXT]))
    after = friction + share * (left - friction)
    trusted = x[TRUSTED] + row.trust * (limit - x[TRUSTED])
    found = np.zeros((STATES, x.shape[1]))
    found[LIMIT], found[FRICTION], found[TRUSTED] = limit, after, trusted
    found[SENSOR] = a @ sensor + np.outer(b0, friction) + np.outer(b1, after)
    found[NOW], found[NEXT] = x[NEXT], after - after / row.lead - trusted
    return found, x[TRUE_FRICTION]
