"""From a System to a controller of higher order: mixed-sensitivity H-infinity, and LQG beside it.

Weights are identified, not chosen: the residual counts as the spectrum of the friction noise and tremor
(noise_model), if asked as touch feels it. What is left to choose, how much performance, is the most that holds on
every plant of a grid (robustness).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.analysis.linear import linearise
from frictionloop.analysis.margins import margins
from frictionloop.analysis.state_space import Complex
from frictionloop.design.high_order import Lead, Method, Synthesised
from frictionloop.design.hinf_wanted import HinfWanted, broken, check
from frictionloop.design.noise_model import NoiseModel, identify_noise
from frictionloop.design.plant_grid import PlantGrid
from frictionloop.design.quadruple import Quadruple, balanced, bilinear
from frictionloop.design.sections import factorise
from frictionloop.design.slicot import Generalised, lqg, synthesise
from frictionloop.design.weighted_plant import (
    BOTH_CONTACTS,
    ONE_CONTACT,
    SHAPING_STATES,
    Weights,
    check_order,
    weighted_plant,
)
from frictionloop.parameters import LowpassSensor, Skin, System
from frictionloop.quantities import FrictionloopError

PERFORMANCE = (10.0, 5000.0)
"""Range of `Weights.performance` in which the most that holds is looked for, 1/N."""
SEARCHES = 12
"""Halvings of that range's logarithm: to 0.2 %."""


def design_hinf(
    system: System,
    noise: NoiseModel | None = None,
    weights: Weights | None = None,
    wanted: HinfWanted | None = None,
    force_n: float | None = None,
) -> Synthesised:
    """Return the H-infinity controller with the most performance that holds over a grid of plants.

        min over K of the norm of [z_res, z_e, z_u] from [w_res, w_in, w_d, w_n]   (weighted_plant)

    Parameters
    ----------
    system
        The bench.
    noise
        Disturbance; None identifies it from plain strokes at the operating point.
    weights
        All but ``performance``, which is searched for. None: `BOTH_CONTACTS`, or `ONE_CONTACT` if one is wanted.
    wanted
        What must hold. None: `HinfWanted` as it is.
    force_n
        Operating point as friction force in N; None as in `linearise`.

    Raises
    ------
    FrictionloopError
        Nothing holds, not even with the least performance: the line says what the limit is. A synthesis that does not
        converge, coefficients that Q31 cannot hold, or a delay of more control periods than it takes (`check_order`).
    """
    return _search("hinf", system, noise, weights, wanted or HinfWanted(), force_n)


def design_lqg(
    system: System,
    noise: NoiseModel | None = None,
    weights: Weights | None = None,
    wanted: HinfWanted | None = None,
    force_n: float | None = None,
) -> Synthesised:
    """Return the LQG controller (Kalman filter, LQR) on the same weighted plant, searched for in the same way.

    Arguments and errors as of `design_hinf`.
    """
    return _search("lqg", system, noise, weights, wanted or HinfWanted(), force_n)


def _search(
    method: Method,
    system: System,
    noise: NoiseModel | None,
    weights: Weights | None,
    wanted: HinfWanted,
    force_n: float | None,
) -> Synthesised:
    weights = weights or (BOTH_CONTACTS if len(wanted.contact) > 1 else ONE_CONTACT)
    check(wanted, weights)
    believed = linearise(_believed(system, weights), force_n=force_n).plant
    check_order(believed, system.controller.delay_s, len(noise.shaping.den) - 1 if noise else SHAPING_STATES)
    noise = noise or identify_noise(system, force_n)
    grid = _grid(system, wanted, force_n)
    exact = linearise(system, force_n=force_n)
    period_s, nyquist_hz = believed.period_s, exact.nyquist_hz
    lead = Lead(_decay(system) if wanted.overdrive else 0.0, period_s)

    def attempt(performance: float) -> Synthesised:
        now = replace(weights, performance=performance)
        K, gamma = _controller(method, weighted_plant(believed, noise.shaping, now))
        small = _reduced(lead.taken_out(K), wanted.order)
        cascade = factorise(small, 1.0, 2 * math.pi * now.integral_hz, period_s)

        def response(f: ArrayLike) -> Complex:
            return np.asarray(cascade.response(f) * lead.response(f))

        def gain(f: ArrayLike) -> Complex:
            return np.asarray(response(f) * exact.plant.response(f)[:, 1, 0])

        table = grid.judged(response, noise)

        stable = bool(table["stable"].sel(resonance=0.0, gain=1.0).isel(contact=0, speed_mm_s=0))
        found = margins(gain, exact.search_grid(1e-2), nyquist_hz, stable)
        noisy = _command_noise_n(response, gain, noise, nyquist_hz)
        orders = len(small.A) + 1, len(K.A) + 1
        return Synthesised(cascade, lead, method, gamma, *orders, now, found, noisy, table, noise)

    return _most(attempt, wanted)


def _most(attempt: Callable[[float], Synthesised], wanted: HinfWanted) -> Synthesised:
    """Return the attempt with the most performance that holds, by bisection."""
    low, high = (math.log(p) for p in PERFORMANCE)
    best = attempt(PERFORMANCE[0])
    reason = broken(best, wanted)
    if reason:
        raise FrictionloopError(reason)
    for _ in range(SEARCHES):
        middle = (low + high) / 2
        try:
            trial = attempt(math.exp(middle))
            holds = not broken(trial, wanted)
        except FrictionloopError:  # an unstable controller or none: too much was asked
            holds = False
        if holds:
            low, best = middle, trial
        else:
            high = middle
    return best


def _command_noise_n(
    response: Callable[[ArrayLike], Complex],
    gain: Callable[[ArrayLike], Complex],
    noise: NoiseModel,
    nyquist_hz: float,
) -> float:
    """Return the rms of u for white noise in f_m, of the density that the sensor has in its pass band."""
    grid = np.linspace(0.0, nyquist_hz, 5001)[1:]
    amplification = np.abs(response(grid) / (1 + gain(grid)))
    return float(noise.sensor_n_rthz * np.sqrt(np.mean(amplification**2) * nyquist_hz))


def _grid(system: System, wanted: HinfWanted, force_n: float | None) -> PlantGrid:
    r = wanted.resonance
    off = (0.0,) if isinstance(system.sensor, LowpassSensor) else tuple(sorted({-2 * r, -r, 0.0, r, 2 * r}))
    speed = getattr(system.motion, "speed_mm_s", 0.0)
    contact: Sequence[str] = wanted.contact if isinstance(system.finger, Skin) else ("none",)
    return PlantGrid.of(system, off, (wanted.gain[0], 1.0, wanted.gain[1]), contact, (speed,), force_n)


def _believed(system: System, weights: Weights) -> System:
    """Return the bench as the synthesis is to see it."""
    changes: dict[str, float] = {}
    if not isinstance(system.sensor, LowpassSensor):
        changes["sensor.resonance_hz"] = system.sensor.resonance_hz * (1 + weights.resonance_bias)
    if isinstance(system.finger, Skin):
        changes["finger.bristle_stiffness_n_m"] = system.finger.bristle_stiffness_n_m * weights.contact_faster
    return system.evolve(changes)


def _decay(system: System) -> float:
    controller = system.controller
    return math.exp(-2.0 * math.pi * controller.model.plate_hz / controller.rate_hz)


def _controller(method: Method, plant: Generalised) -> tuple[Quadruple, float]:
    return (lqg(plant), math.nan) if method == "lqg" else synthesise(plant)


def _reduced(controller: Quadruple, order: int) -> Quadruple:
    """Return a stable controller with at most so many states, by balanced truncation in w."""
    if len(controller.A) <= order or np.abs(np.linalg.eigvals(controller.A)).max() >= 1:
        return controller
    return bilinear(balanced(bilinear(controller), order)[0], back=True)
