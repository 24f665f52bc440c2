"""The elements of equation (2), C, P and S, of a System at an operating point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictionloop.control.lookup import lookup_table
from frictionloop.control.pi import linearise_pi
from frictionloop.parameters import Model, System, check_system
from frictionloop.physics.friction import amplitude_for, friction_force
from frictionloop.physics.plate import linearise_plate
from frictionloop.quantities import FrictionloopError, Lti
from frictionloop.sensing.lowpass import linearise_sensor


@dataclass(frozen=True)
class Elements:
    """C(s), P(s), S(s) of equation (2) for small signals, and where on the friction law they hold."""

    controller: Lti
    """C(s) = (kp + ki/s) exp(-s delay_s), error to force command, N/N."""
    plate: Lti
    """P(s), force command to friction force, N/N: the lookup table, the plate and the friction law lumped."""
    sensor: Lti
    """S(s), force plus noise to measured force, N/N."""
    amplitude_um: float
    """Vibration amplitude of the operating point, um zero-to-peak."""
    force_n: float
    """Friction force g(a) of the operating point, N, without the disturbance."""


def elements(system: System, amplitude_um: float | None = None, force_n: float | None = None) -> Elements:
    """Return C, P and S of equation (2) at an operating point.

    The literal order of the paper's Section 2.2 is kept, low-pass on the amplitude, then g: small signals then see
    P(s) = `lumped_gain` times the plate's low-pass.

    Parameters
    ----------
    system
        The loop.
    amplitude_um
        Vibration amplitude of the operating point, um, from 0 to the smaller a_max of plate and controller model.
    force_n
        The operating point as a force g(a) instead, N. Without either: the middle of the reachable forces.

    Raises
    ------
    FrictionloopError
        Both are given, or the point cannot be reached.
    """
    check_system(system)
    amplitude = _operating_amplitude_um(system, amplitude_um, force_n)
    gain = lumped_gain(system, amplitude)
    return Elements(
        controller=linearise_pi(system.controller),
        plate=Lti((gain,), (1.0,)) * linearise_plate(system.plate),
        sensor=linearise_sensor(system.sensor),
        amplitude_um=amplitude,
        force_n=float(friction_force(amplitude, system.friction)),
    )


def lumped_gain(system: System, amplitude_um: float) -> float:
    """Return df/du of lookup table and friction law in series, -tau g(a) d(a^2)/du; 1 where the model is right.

    With the exact inverse this is g'(a) / g_model'(a), finite at a = 0 too; with a table d(a^2)/du is the slope of
    the cell that holds ``amplitude_um``.
    """
    force = float(friction_force(amplitude_um, system.friction))
    slope = _square_per_newton(system.controller.model, amplitude_um)
    return -system.friction.susceptibility_per_um2 * force * slope


def _square_per_newton(model: Model, amplitude_um: float) -> float:
    """Return d(a^2)/du of the lookup table in um^2/N."""
    if model.table_size == 0:
        believed = model.nominal_n * math.exp(-model.susceptibility_per_um2 * amplitude_um**2)
        return -1.0 / (model.susceptibility_per_um2 * believed)
    squares = lookup_table(model)
    cell = int(np.clip(np.searchsorted(-squares, -(amplitude_um**2), side="right") - 1, 0, squares.size - 2))
    spacing_n = (model.nominal_n - model.floor_n) / (squares.size - 1)
    return float(squares[cell + 1] - squares[cell]) / spacing_n


def _operating_amplitude_um(system: System, amplitude_um: float | None, force_n: float | None) -> float:
    limit_um = min(system.plate.max_amplitude_um, system.controller.model.max_amplitude_um)
    floor_n, nominal_n = float(friction_force(limit_um, system.friction)), system.friction.nominal_n
    if amplitude_um is not None and force_n is not None:
        raise FrictionloopError("operating point: give amplitude_um or force_n, not both")
    if amplitude_um is not None:
        if not 0 <= amplitude_um <= limit_um:
            raise FrictionloopError(f"amplitude_um = {amplitude_um:g} um: must be between 0 and {limit_um:g}")
        return float(amplitude_um)
    force = (floor_n + nominal_n) / 2 if force_n is None else force_n
    if not floor_n <= force <= nominal_n:
        raise FrictionloopError(f"force_n = {force:g} N: must be between {floor_n:.6g} and {nominal_n:g}")
    return float(amplitude_for(force, system.friction))
