"""The lookup table, force command u to amplitude command, the inverse of g by the controller's model (Section 2.2).

Alone it is a law too: the set-point commands the force and nothing is fed back (ref. [15]).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionloop.control.law import Clamp, ForceCommand, Law, clamp_of
from frictionloop.parameters import Model
from frictionloop.quantities.arithmetic import fma, log2, step
from frictionloop.sensing.measurement import Measurement


@step
def inverse_step(u: float, log2_nominal: float, um2_per_halving: float) -> float:
    """a = sqrt((log2 f0 - log2 u) ln 2 / tau) = sqrt(ln(f0/u) / tau): the exact inverse of equation (1)."""
    return math.sqrt(max((log2_nominal - log2(u)) * um2_per_halving, 0.0))


@step
def table_position(u: float, low_n: float, cells_per_n: float, last_cell: float) -> tuple[int, int, float]:
    """Return the entries of the table below and above u, and how far u lies between them (0 to 1)."""
    position = (u - low_n) * cells_per_n
    cell = min(max(math.floor(position), 0.0), last_cell)
    return int(cell), int(cell) + 1, position - cell


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


class NoState(NamedTuple):
    """The table remembers nothing; the number is not used."""

    nothing: float


@step
def open_loop_step(
    state: NoState, measurement: Measurement, setpoint_n: float, gains: Clamp, dt: float
) -> tuple[NoState, ForceCommand]:
    """u = clip(f_r, low, high), whatever is measured."""
    low, high = gains
    u = min(max(setpoint_n, low), high)
    return state, ForceCommand(u, 1.0 if setpoint_n != u else 0.0)


LOOKUP_LAW = Law("lookup", open_loop_step, NoState, Clamp, lambda c: clamp_of(c.model))
