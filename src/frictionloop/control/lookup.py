"""The lookup table, force command u to amplitude command, the inverse of g by the controller's model (Section 2.2).

Alone it is a law too: the set-point commands the force and nothing is fed back (ref. [15]). Behind it may come
overdrive: the amplitude command overshoots so that the plate gets where it is wanted in one period (ref. [14]).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from frictionloop.control.law import Clamp, ForceCommand, Law, clamp_of
from frictionloop.parameters import Model
from frictionloop.quantities.scalar_math import fma, log2, step
from frictionloop.sensing.measurement import Measurement


@step
def inverse_step(u: float, log2_nominal: float, um2_per_halving: float) -> float:
    """a = sqrt((log2 f0 - log2 u) ln 2 / tau) = sqrt(ln(f0/u) / tau): the exact inverse of equation (1)."""
    return math.sqrt(max((log2_nominal - log2(u)) * um2_per_halving, 0.0))


def inverse_numbers(model: Model) -> tuple[float, float]:
    """Return what `inverse_step` takes of a model beside the force: log2 f0 (N), and ln 2/tau in um^2."""
    return float(np.log2(model.nominal_n)), math.log(2.0) / model.susceptibility_per_um2


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
    error of linear interpolation then is h^2/(8 u) with h the spacing in N. A table that was measured
    (``model.table_um2``) is taken in place of the law's, linear between its entries.
    """
    if model.table_um2:
        places = np.linspace(0.0, 1.0, model.table_size)
        return np.interp(places, np.linspace(0.0, 1.0, len(model.table_um2)), model.table_um2)
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


class OverdriveGains(NamedTuple):
    """Decay e^(-2 pi f_plate dt) of the believed plate, 1/(1 - decay), and the largest amplitude in um."""

    decay: float
    inverse: float
    largest_um: float


@step
def overdrive_step(amplitude_um: float, wanted_um: float, gains: OverdriveGains) -> tuple[float, float]:
    """c = clip((a_w - p a)/(1 - p), 0, a_max), then a' = p a + (1 - p) c: new belief, and command."""
    decay, inverse, largest = gains
    command = min(max(fma(-decay, amplitude_um, wanted_um) * inverse, 0.0), largest)
    return fma(decay, amplitude_um - command, command), command


def overdrive_gains(controller: Any) -> OverdriveGains:
    """Return the gains for a controller, with overdrive or without."""
    if not getattr(controller, "overdrive", False):
        return no_overdrive(controller.model)
    decay = math.exp(-2.0 * math.pi * controller.model.plate_hz / controller.rate_hz)
    return OverdriveGains(decay, 1.0 / (1.0 - decay), controller.model.max_amplitude_um)


def no_overdrive(model: Model) -> OverdriveGains:
    """Return the gains with which the believed plate follows at once, and nothing changes."""
    return OverdriveGains(0.0, 1.0, model.max_amplitude_um)
