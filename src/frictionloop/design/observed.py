"""Observers tuned within margins: bandwidth and believed resonance with the least residual."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionloop.analysis.closed import close
from frictionloop.analysis.disturbance import Spectrum
from frictionloop.analysis.law_space import law_space
from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.state_space import Array, Complex, StateSpace
from frictionloop.design.corners import with_shifts
from frictionloop.parameters import SuspendedSensor, System
from frictionloop.quantities import FrictionloopError

BIASES = (0.0, -0.03, -0.06, -0.1)
"""Believed resonance over that of the bench, less 1: too low is benign, too high fatal (control/super_twisting)."""
BANDWIDTHS = 20
LOWEST_HZ = 1.0
"""Lowest bandwidth tried; the highest is half the control rate."""
GUARD = 0.99
"""Share of a limit on Ms that is used: |S| is looked at on a grid."""


@dataclass(frozen=True, eq=False)
class _Case:
    """One loop without its law: what a law of any gains is judged on."""

    space: StateSpace
    frequency_hz: Array
    response: Complex
    """f_m from u."""
    peak: float
    """Largest Ms."""
    off: float


def tune_observer(
    system: System, kind: str, limits: Mapping[float, float], disturbance: Spectrum | None
) -> dict[str, Any]:
    """Return overrides of an observing law with the least residual within margins.

    Parameters
    ----------
    system
        The bench.
    kind
        Kind of an `Observing` controller.
    limits
        Largest Ms by the share that the resonance is off.
    disturbance
        Spectrum whose residual is to be least; None: the largest bandwidth.

    Raises
    ------
    FrictionloopError
        No bandwidth holds: the line says how close the best one comes, and where.
    """
    base = system.evolve({"controller.kind": kind})
    shifted = with_shifts(system.evolve({"controller.kind": "pi"}), limits)
    cases = [_case(loop, off, peak) for loop, off, peak in shifted]
    at = min((loop for loop, off, _ in shifted if off == 0.0), key=lambda loop: loop.elements.occluded)
    tried = [(_judge(base, each, at, cases, disturbance), each) for each in _candidates(system)]
    (excess, _, case), best = min(tried, key=lambda found: found[0][:2])
    if excess > 1.0:
        where = f"with the resonance {case.off:+.0%} off" if case.off else "with the resonance as described"
        limit = "the resonance is the limit" if case.off else "delay and lags of the loop are the limit"
        raise FrictionloopError(
            f"sensitivity_peak = {limits[0.0]:g}: no bandwidth of law {kind} holds it; the best, "
            f"{best['controller.bandwidth_hz']:.4g} Hz, gets to Ms {excess * GUARD * case.peak:.3g} where "
            f"{case.peak:.3g} is asked, {where}; {limit}"
        )
    return {"controller.kind": kind, **best}


def _candidates(system: System) -> list[dict[str, Any]]:
    highest = system.controller.rate_hz / 2.0
    bandwidths = np.geomspace(LOWEST_HZ, highest, BANDWIDTHS).tolist()
    if not isinstance(system.sensor, SuspendedSensor):
        return [{"controller.bandwidth_hz": hz} for hz in bandwidths]
    resonance = system.sensor.resonance_hz
    return [
        {"controller.bandwidth_hz": hz, "controller.model.resonance_hz": resonance * (1.0 + bias)}
        for bias in BIASES
        for hz in bandwidths
    ]


def _case(loop: LinearLoop, off: float, peak: float) -> _Case:
    grid = loop.search_grid(1e-2)
    frequency = np.append(grid[grid >= 1e-2], loop.nyquist_hz)
    return _Case(loop.plant.state_space(), frequency, loop.plant.response(frequency)[:, 1, 0], peak, off)


def _judge(
    base: System, overrides: Mapping[str, Any], at: LinearLoop, cases: list[_Case], disturbance: Spectrum | None
) -> tuple[float, float, _Case]:
    """Return the largest Ms over its limit, at least 1; the residual, or minus the bandwidth; and where Ms is worst."""
    try:
        law = law_space(base.evolve(dict(overrides)), at.elements, at.plant)
    except FrictionloopError:
        return math.inf, math.inf, cases[0]
    worst, residual, where = 1.0, 0.0, cases[0]
    for case in cases:
        distance = np.abs(1.0 - law.response(case.frequency_hz)[:, 1, 1] * case.response)
        stable = close(case.space, law).is_stable()
        excess = float(1.0 / distance.min()) / (GUARD * case.peak) if stable else math.inf
        if excess > worst:
            worst, where = excess, case
        if disturbance is not None:
            power = disturbance(case.frequency_hz) / distance**2
            residual = max(residual, float(np.trapezoid(power, case.frequency_hz)))
    cost = -float(overrides["controller.bandwidth_hz"]) if disturbance is None else math.sqrt(residual)
    return worst, cost, where
