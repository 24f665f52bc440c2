"""The lookup table: force command u to amplitude command, the inverse of g by the controller's model (Section 2.2)."""

from __future__ import annotations

import math

import numpy as np

from frictionloop.parameters import Model
from frictionloop.quantities.arithmetic import fma, log2, step


@step
def inverse_step(u: float, log2_nominal: float, um2_per_halving: float) -> float:
    """a = sqrt((log2 f0 - log2 u) ln 2 / tau) = sqrt(ln(f0/u) / tau): the exact inverse of equation (1)."""
    return math.sqrt(max((log2_nominal - log2(u)) * um2_per_halving, 0.0))


@step
def table_position(u: float, low_n: float, cells_per_n: float, last_cell: float) -> tuple[int, float]:
    """Return the table cell of u and the fraction within it."""
    position = (u - low_n) * cells_per_n
    cell = min(max(math.floor(position), 0.0), last_cell)
    return int(cell), position - cell


@step
def interpolate_step(fraction: float, square_0: float, square_1: float) -> float:
    """a = sqrt of a^2 interpolated linearly between two entries."""
    return math.sqrt(max(fma(fraction, square_1 - square_0, square_0), 0.0))


def lookup_table(model: Model) -> np.ndarray:
    """Return the table: a^2 = ln(f0/u)/tau in um^2 at ``table_size`` forces from g(a_max) to f0.

    The square is tabulated because a(u) has a vertical tangent at u = f0, where a^2 is smooth; the largest force
    error of linear interpolation then is h^2/(8 u) with h the spacing in N.
    """
    u = np.linspace(model.floor_n, model.nominal_n, model.table_size)
    return np.asarray(np.log(model.nominal_n / u) / model.susceptibility_per_um2)
