"""The plant that the tracker's rows are made for, as the linear optimum takes it: one numerator to each output."""

from __future__ import annotations

import numpy as np
from scipy.signal import ss2tf

from frictionloop.analysis.state_space import Array
from frictionloop.control.tracker_gains import sensor_matrices
from frictionloop.design.tracker_loop import Plant


def plant_paths(plant: Plant, dt: float) -> tuple[Array, Array, Array]:
    """Return numerators to reading and friction from the limit that is commanded, and poles: coefficients of z^-k."""
    a, b0, b1 = sensor_matrices(plant.sensor, dt)
    now, ahead, friction = np.eye(6)[:3]
    left = plant.gain * (ahead if plant.share >= 1.0 else 0.5 * (now + ahead))
    matrix = np.zeros((6, 6))
    matrix[0], matrix[2] = ahead, friction + plant.share * (left - friction)
    matrix[3:, 3:] = a
    matrix[3:] += np.outer(b0, friction) + np.outer(b1, matrix[2])
    numerators, poles = ss2tf(matrix, np.eye(6)[:, [1]], np.eye(6)[[5, 2]], np.zeros((2, 1)))
    return numerators[0], numerators[1], poles
