"""Four load cells under a rigid plate: statics, load and centre of pressure, and what their noise makes of it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionloop.parameters.touch import LoadCells
from frictionloop.quantities import FrictionloopError

CORNERS = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
"""Signs of (x, y) of the four cells, in the order of every array of cells."""


def cell_forces(
    load_n: np.ndarray | float,
    x_mm: np.ndarray | float,
    y_mm: np.ndarray | float,
    cells: LoadCells,
    tangential_n: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Return the force on each cell in N, shape (..., 4) in the order of ``CORNERS``.

    A rigid plate of length L and width W on four equal springs: F_i = N/4 + s_xi (N x + T h)/(2 L) + s_yi N y/(2 W).

    Parameters
    ----------
    load_n : array or float
        Normal force N, at least 0.
    x_mm, y_mm : array or float
        Where the finger presses, from the middle of the plate, within the cells.
    cells : LoadCells
        L, W and the height h of the touched face above the cells.
    tangential_n : array or float
        Force T of the finger on the plate along +x: the friction force when the finger moves to +x.

    Raises
    ------
    FrictionloopError
        For a load that is negative or a place outside the cells, or what is not finite.
    """
    load, x, y, tangential = np.broadcast_arrays(load_n, x_mm, y_mm, tangential_n)
    for name, values, low, high, unit in (
        ("load_n", load, 0.0, math.inf, "N"),
        ("x_mm", x, -cells.length_mm / 2, cells.length_mm / 2, "mm"),
        ("y_mm", y, -cells.width_mm / 2, cells.width_mm / 2, "mm"),
        ("tangential_n", tangential, -math.inf, math.inf, "N"),
    ):
        wrong = values[~(np.isfinite(values) & (values >= low) & (values <= high))]
        if wrong.size:
            raise FrictionloopError(f"{name} = {wrong.flat[0]:g} {unit}: must be finite, from {low:g} to {high:g}")
    moment_x = (load * x + tangential * cells.height_mm) / cells.length_mm
    moment_y = load * y / cells.width_mm
    return np.asarray(
        load[..., None] / 4 + (CORNERS[:, 0] * moment_x[..., None] + CORNERS[:, 1] * moment_y[..., None]) / 2
    )


class CentreOfPressure(NamedTuple):
    """Load in N and centre of pressure in mm with their standard deviations; NaN in mm where there is no touch."""

    load_n: np.ndarray
    x_mm: np.ndarray
    y_mm: np.ndarray
    load_noise_n: float
    x_noise_mm: np.ndarray
    y_noise_mm: np.ndarray
    valid: np.ndarray
    """1 where the load is at least ``touch_n``, else 0."""


def centre_of_pressure(
    forces_n: np.ndarray, cells: LoadCells, tangential_n: np.ndarray | float = 0.0
) -> CentreOfPressure:
    """Return load and centre of pressure from four cells, with their noise.

    N = sum F_i, x = (L/2 sum s_xi F_i - T h)/N, y = W/2 sum s_yi F_i/N. With noise sigma of each cell, to first order
    in sigma/N: sigma_N = 2 sigma, sigma_x = sigma/N sqrt(L^2 + 4 x^2), sigma_y = sigma/N sqrt(W^2 + 4 y^2).

    Parameters
    ----------
    forces_n : array
        Forces on the cells, shape (..., 4) in the order of ``CORNERS``.
    cells : LoadCells
        Distances, height, noise and least load.
    tangential_n : array or float
        Force T of the finger on the plate along +x, as the lateral sensor measures it.

    Raises
    ------
    FrictionloopError
        For forces of another shape.
    """
    forces = np.asarray(forces_n, dtype=float)
    if forces.shape[-1:] != (4,):
        raise FrictionloopError(f"forces_n has shape {forces.shape}; accepted: (..., 4)")
    load = forces.sum(axis=-1)
    valid = load >= cells.touch_n
    safe = np.where(valid, load, np.nan)
    moment = forces @ CORNERS
    x = (cells.length_mm / 2 * moment[..., 0] - np.asarray(tangential_n) * cells.height_mm) / safe
    y = cells.width_mm / 2 * moment[..., 1] / safe
    x_noise = cells.noise_n / safe * np.hypot(cells.length_mm, 2 * x)
    y_noise = cells.noise_n / safe * np.hypot(cells.width_mm, 2 * y)
    return CentreOfPressure(load, x, y, 2 * cells.noise_n, x_noise, y_noise, valid.astype(float))
