"""From a System to a controller of higher order: mixed-sensitivity H-infinity, and LQG beside it.

Weights are identified, not chosen: the residual counts as the spectrum of the friction noise and tremor
(noise_model), if asked as touch feels it. What is left to choose, how much performance, is the most that holds on
every plant of a grid: each contact with each error of the resonance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.design.corners import broken, corners, stroke_of
from frictionloop.design.noise_model import NoiseModel, identify_noise
from frictionloop.design.over import Over
from frictionloop.design.plants import Plants, lead, overdrive_decay, shifted
from frictionloop.design.quadruple import Quadruple, balanced, bilinear, slicot
from frictionloop.design.sections import Cascade, Method, Synthesised, factorise, lagged
from frictionloop.design.slicot import Generalised, lqg, synthesise
from frictionloop.design.wanted import Designed, Wanted, feedforward, unfound, unheld
from frictionloop.design.weighted_plant import ALL_LENGTHS, SHAPING_STATES, Weights, check_order, weighted_plant
from frictionloop.parameters import LowpassSensor, Skin, System
from frictionloop.parameters.filtered import FILTERS
from frictionloop.quantities import FrictionloopError

GAINS = (0.65, 2.0)
"""Factors on the loop gain at which it has to be stable with every error of the resonance.

A finger's is F tau/(u tau_model) behind the lookup; at 0.6 N it is 1.05 to 1.86 from the first to the last decile of
the capable among ``fingers(100, 3)`` on the bench.
"""
COMMAND_NOISE_N = 0.03
"""Largest rms of the command that sensor noise causes: beyond it the command strays into the clamp (assumed)."""
ORDER = 2 * FILTERS
"""Most states of the sections."""

FELT_HZ = (1.0, 500.0)
"""Band of the residual that is told."""
PERFORMANCE = (10.0, 5000.0)
"""Range of `Weights.performance` in which the most that holds is looked for, 1/N."""
SEARCHES = 12
"""Halvings of that range's logarithm: to 0.2 %."""


def design_hinf(system: System, noise: NoiseModel | None = None, wanted: Wanted | None = None) -> Synthesised:
    """Return the H-infinity controller with the most performance that holds over a grid of plants.

        min over K of the norm of [z_res, z_e, z_u] from [w_res, w_in, w_d, w_n]   (weighted_plant)

    Parameters
    ----------
    system
        The bench.
    noise
        Disturbance; None identifies it from plain strokes at the operating point.
    wanted
        What must hold, at the bench's own gain. None: `Wanted` as it is.

    Raises
    ------
    FrictionloopError
        Nothing holds, not even with the least performance: the line says what the limit is. A synthesis that does not
        converge, coefficients that Q31 cannot hold, or a delay of more control periods than it takes (`check_order`).
    """
    return _search("hinf", system, noise, (wanted or Wanted()).limits)


def design_lqg(system: System, noise: NoiseModel | None = None, wanted: Wanted | None = None) -> Synthesised:
    """Return the LQG controller (Kalman filter, LQR) on the same weighted plant, searched for in the same way.

    Arguments and errors as of `design_hinf`.
    """
    return _search("lqg", system, noise, (wanted or Wanted()).limits)


TIGHTER = (1.0, 0.8, 0.6, 0.45, 0.3)
"""Shares of Ms - 1 that are tried where a synthesis does not see every corner."""


def synthesised(method: Method, system: System, wanted: Wanted) -> Designed:
    """Return the controller of the least tightened limits that holds at every corner, not only on the method's grid."""
    forward, notes = feedforward(system)
    # Identifying the noise already takes seconds.
    slicot()
    check_order(linearise(system).plant, system.controller.delay_s)
    noise = identify_noise(system)
    first = ""
    for share in TIGHTER:
        try:
            found = _search(method, system, noise, wanted.scaled(share))
        except FrictionloopError as error:
            first = first or str(error)
            continue
        overrides = {**found.overrides, "controller.feedforward": forward}
        at = corners(system.evolve(overrides), wanted.limits, wanted.places, wanted.lean)
        worst = broken(at)
        if worst is None:
            said = f"{found.order} states, reduced from {found.full_order}"
            return Designed(overrides, (*notes, said), tuple(at))
        first = first or unheld(found.method, wanted, worst)
    raise FrictionloopError(first)


def _points(system: System) -> list[LinearLoop]:
    """Return the loop at the operating point of `linearise`, at both ends of the slip length of a skin."""
    return [linearise(each) for each in Over(None).systems(system)]


def _search(method: Method, system: System, noise: NoiseModel | None, limits: Mapping[float, float]) -> Synthesised:
    believed = linearise(_believed(system, ALL_LENGTHS)).plant
    check_order(believed, system.controller.delay_s, len(noise.shaping.den) - 1 if noise else SHAPING_STATES)
    noise = noise or identify_noise(system)
    period_s, decay = believed.period_s, overdrive_decay(system)
    cases = sorted(shifted(_points(system), limits), key=lambda case: abs(case[1]))  # the bench as described first
    plants = Plants.of([loop for loop, _, _ in cases], overdrive=True)

    def attempt(performance: float) -> Synthesised:
        now = replace(ALL_LENGTHS, performance=performance)
        K, gamma = _controller(method, weighted_plant(believed, noise.shaping, now))
        small = _reduced(lagged(K, decay), ORDER)
        cascade = factorise(small, 1.0, 2 * math.pi * now.integral_hz, period_s)
        orders = len(small.A) + 1, len(K.A) + 1
        offs = [off for _, off, _ in cases]
        told = _figures(cascade, decay, plants, offs, noise)
        return Synthesised(cascade, decay, method, gamma, *orders, now, noise, **told)

    def reason(found: Synthesised) -> str:
        """Return in one line what does not hold, or nothing."""
        law = found.cascade.response(plants.frequency_hz)
        over = plants.peaks(law) / [limit for _, _, limit in cases]
        loop, off, limit = cases[int(np.argmax(over))]
        if not np.max(over) <= 1.0:
            return (
                f"sensitivity_peak = {limits[0.0]:g}: the {method} controller gets to {limit * np.max(over):.3g} where "
                f"{limit:.3g} is asked, with the resonance off by {off:.3g}{stroke_of(loop.system)}"
            )
        if not all(plants.stable(factor * law).all() for factor in GAINS):
            return f"the {method} controller is not stable with the loop gain times {GAINS[0]:g} and {GAINS[1]:g}"
        if not found.command_noise_n <= COMMAND_NOISE_N:
            return (
                f"sensor noise makes {found.command_noise_n:.3g} N of command with the {method} controller, and "
                f"{COMMAND_NOISE_N:g} N is the most: it needs {COMMAND_NOISE_N / found.command_noise_n:.2f} times the "
                "sensor's noise or less (sensor.noise_density_n_rthz, or noise_rms_n; adc_bits); with this noise take "
                "`--law notch_pi` or pi, and the smaller gain that `frictionloop design check` names"
            )
        return ""

    return _most(attempt, reason, unfound(method, system))


def _figures(
    cascade: Cascade, decay: float, plants: Plants, offs: Sequence[float], noise: NoiseModel
) -> dict[str, Any]:
    """Return what is told of a controller: Ms by error of the resonance, noise of the command, residual."""
    f, period_s = plants.frequency_hz, cascade.period_s
    law = cascade.response(f)
    peaks: dict[float, float] = {}
    for peak, off in zip(plants.peaks(law).tolist(), offs, strict=True):
        peaks[off] = max(peak, peaks.get(off, 0.0))
    returned = plants.returned(law)[0]
    command = law * lead(decay, f, period_s) / returned
    felt = np.where((f >= FELT_HZ[0]) & (f <= FELT_HZ[1]), noise.density(f), 0.0)
    return {
        "peaks": peaks,
        "command_noise_n": noise.sensor_n_rthz * math.sqrt(float(np.trapezoid(np.abs(command) ** 2, f))),
        "residual_rms_n": float(plants.residual_n(law, felt)[0]),
    }


def _most(attempt: Callable[[float], Synthesised], broken: Callable[[Synthesised], str], none: str) -> Synthesised:
    """Return the attempt with the most performance that holds, by bisection; ``none`` is said where the least fails."""
    low, high = (math.log(p) for p in PERFORMANCE)
    try:
        best = attempt(PERFORMANCE[0])
    except FrictionloopError as error:
        raise FrictionloopError(f"{none}: {error}") from None
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
        changes["finger.slip_length_um"] = system.finger.slip_length_um / weights.contact_faster
    return system.evolve(changes)


def _controller(method: Method, plant: Generalised) -> tuple[Quadruple, float]:
    return (lqg(plant), math.nan) if method == "lqg" else synthesise(plant)


def _reduced(controller: Quadruple, order: int) -> Quadruple:
    """Return a stable controller with at most so many states, by balanced truncation in w."""
    if len(controller.A) <= order or np.abs(np.linalg.eigvals(controller.A)).max() >= 1:
        return controller
    return bilinear(balanced(bilinear(controller), order)[0], back=True)
