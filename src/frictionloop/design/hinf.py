"""From a System to a controller of higher order: mixed-sensitivity H-infinity, and LQG beside it.

Weights are identified, not chosen: the residual counts as the spectrum of the friction noise and tremor
(noise_model), if asked as touch feels it. What is left to choose, how much performance, is the most that holds on
every plant of a grid (robustness).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from frictionloop.analysis.linear import linearise
from frictionloop.design.hinf_wanted import Cases, HinfWanted, check
from frictionloop.design.noise_model import NoiseModel, identify_noise
from frictionloop.design.plants import lead, overdrive_decay
from frictionloop.design.quadruple import Quadruple, balanced, bilinear
from frictionloop.design.sections import Cascade, Method, Synthesised, factorise, lagged
from frictionloop.design.slicot import Generalised, lqg, synthesise
from frictionloop.design.weighted_plant import (
    BOTH_CONTACTS,
    SHAPING_STATES,
    Weights,
    check_order,
    weighted_plant,
)
from frictionloop.parameters import LowpassSensor, Skin, System
from frictionloop.quantities import FrictionloopError

FELT_HZ = (1.0, 500.0)
"""Band of the residual that is told."""
PERFORMANCE = (10.0, 5000.0)
"""Range of `Weights.performance` in which the most that holds is looked for, 1/N."""
SEARCHES = 12
"""Halvings of that range's logarithm: to 0.2 %."""


def design_hinf(system: System, noise: NoiseModel | None = None, wanted: HinfWanted | None = None) -> Synthesised:
    """Return the H-infinity controller with the most performance that holds over a grid of plants.

        min over K of the norm of [z_res, z_e, z_u] from [w_res, w_in, w_d, w_n]   (weighted_plant)

    Parameters
    ----------
    system
        The bench.
    noise
        Disturbance; None identifies it from plain strokes at the operating point.
    wanted
        What must hold. None: `HinfWanted` as it is.

    Raises
    ------
    FrictionloopError
        Nothing holds, not even with the least performance: the line says what the limit is. A synthesis that does not
        converge, coefficients that Q31 cannot hold, or a delay of more control periods than it takes (`check_order`).
    """
    return _search("hinf", system, noise, wanted or HinfWanted())


def design_lqg(system: System, noise: NoiseModel | None = None, wanted: HinfWanted | None = None) -> Synthesised:
    """Return the LQG controller (Kalman filter, LQR) on the same weighted plant, searched for in the same way.

    Arguments and errors as of `design_hinf`.
    """
    return _search("lqg", system, noise, wanted or HinfWanted())


def _search(method: Method, system: System, noise: NoiseModel | None, wanted: HinfWanted) -> Synthesised:
    check(wanted)
    believed = linearise(_believed(system, BOTH_CONTACTS)).plant
    check_order(believed, system.controller.delay_s, len(noise.shaping.den) - 1 if noise else SHAPING_STATES)
    noise = noise or identify_noise(system)
    cases, period_s, decay = Cases.of(system, wanted), believed.period_s, overdrive_decay(system)

    def attempt(performance: float) -> Synthesised:
        now = replace(BOTH_CONTACTS, performance=performance)
        K, gamma = _controller(method, weighted_plant(believed, noise.shaping, now))
        small = _reduced(lagged(K, decay), wanted.order)
        cascade = factorise(small, 1.0, 2 * math.pi * now.integral_hz, period_s)
        orders = len(small.A) + 1, len(K.A) + 1
        return Synthesised(cascade, decay, method, gamma, *orders, now, noise, **_figures(cascade, decay, cases, noise))

    def reason(found: Synthesised) -> str:
        """Return in one line what does not hold, or nothing."""
        margin = cases.broken(found.cascade.response(cases.plants.frequency_hz), wanted, method)
        if not margin and not found.command_noise_n <= wanted.command_noise_n:
            return (
                f"command_noise_n = {wanted.command_noise_n:g} N: sensor noise makes {found.command_noise_n:.3g} N of "
                f"command with the {method} controller"
            )
        return margin

    return _most(attempt, reason)


def _figures(cascade: Cascade, decay: float, cases: Cases, noise: NoiseModel) -> dict[str, Any]:
    """Return what is told of a controller: Ms by error of the resonance, noise of the command, residual."""
    f, period_s = cases.plants.frequency_hz, cascade.period_s
    law = cascade.response(f)
    peaks: dict[float, float] = {}
    for peak, off, _ in cases.peaks(law):
        peaks[off] = max(peak, peaks.get(off, 0.0))
    returned = cases.plants.returned(law)[0]
    command = law * lead(decay, f, period_s) / returned
    felt = np.where((f >= FELT_HZ[0]) & (f <= FELT_HZ[1]), noise.density(f), 0.0)
    return {
        "peaks": peaks,
        "command_noise_n": noise.sensor_n_rthz * math.sqrt(float(np.trapezoid(np.abs(command) ** 2, f))),
        "residual_rms_n": float(cases.plants.residual_n(law, felt)[0]),
    }


def _most(attempt: Callable[[float], Synthesised], broken: Callable[[Synthesised], str]) -> Synthesised:
    """Return the attempt with the most performance that holds, by bisection."""
    low, high = (math.log(p) for p in PERFORMANCE)
    best = attempt(PERFORMANCE[0])
    reason = broken(best)
    if reason:
        raise FrictionloopError(reason)
    for _ in range(SEARCHES):
        middle = (low + high) / 2
        try:
            trial = attempt(math.exp(middle))
            holds = not broken(trial)
        except FrictionloopError:  # an unstable controller or none: too much was asked
            holds = False
        if holds:
            low, best = middle, trial
        else:
            high = middle
    return best


def _believed(system: System, weights: Weights) -> System:
    """Return the bench as the synthesis is to see it."""
    changes: dict[str, float] = {}
    if not isinstance(system.sensor, LowpassSensor):
        changes["sensor.resonance_hz"] = system.sensor.resonance_hz * (1 + weights.resonance_bias)
    if isinstance(system.finger, Skin):
        changes["finger.bristle_stiffness_n_m"] = system.finger.bristle_stiffness_n_m * weights.contact_faster
    return system.evolve(changes)


def _controller(method: Method, plant: Generalised) -> tuple[Quadruple, float]:
    return (lqg(plant), math.nan) if method == "lqg" else synthesise(plant)


def _reduced(controller: Quadruple, order: int) -> Quadruple:
    """Return a stable controller with at most so many states, by balanced truncation in w."""
    if len(controller.A) <= order or np.abs(np.linalg.eigvals(controller.A)).max() >= 1:
        return controller
    return bilinear(balanced(bilinear(controller), order)[0], back=True)
