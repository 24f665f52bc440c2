"""Observers tuned within margins: bandwidth and believed resonance with the least residual."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from frictionloop.analysis.disturbance import Spectrum
from frictionloop.analysis.law_space import law_space
from frictionloop.analysis.state_space import close
from frictionloop.design.corners import band_of
from frictionloop.design.over import ITSELF, Over
from frictionloop.design.plants import Plants, shifted
from frictionloop.parameters import SuspendedSensor, System
from frictionloop.quantities import FrictionloopError

BIASES = (0.0, -0.03, -0.06, -0.1)
"""Believed resonance over that of the bench, less 1: too low is benign, too high fatal (control/super_twisting)."""
BANDWIDTHS = 20
LOWEST_HZ = 1.0
"""Lowest bandwidth tried; the highest is half the control rate."""
GUARD = 0.99
"""Share of a limit on Ms that is used: |S| is looked at on a grid."""


def tune_observer(
    system: System,
    kind: str,
    limits: Mapping[float, float],
    disturbance: Spectrum | None,
    over: Over = ITSELF,
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
    over
        Slip lengths, speeds and loads at which it has to hold.

    Raises
    ------
    FrictionloopError
        No bandwidth holds: the line says how close the best one comes, and where.
    """
    base = system.evolve({"controller.kind": kind})
    cases = shifted(band_of(system.evolve({"controller.kind": "pi"}), over), limits)
    plants, peaks = Plants.of([loop for loop, _, _ in cases]), np.array([peak for _, _, peak in cases])
    spaces = [loop.plant.state_space() for loop, _, _ in cases]
    density = None if disturbance is None else disturbance(plants.frequency_hz)
    at = min((loop for loop, off, _ in cases if off == 0.0), key=lambda loop: loop.elements.occluded)

    def judged(changes: Mapping[str, Any]) -> tuple[float, float, int]:
        """Return the largest Ms over its limit, at least 1; the residual, or minus the bandwidth; the worst case."""
        try:
            law = law_space(base.evolve(dict(changes)), at.elements, at.plant)
        except FrictionloopError:
            return math.inf, math.inf, 0
        gain = -law.response(plants.frequency_hz)[:, 1, 1]
        stable = [close(space, law).is_stable() for space in spaces]  # the law itself may not be
        over = np.where(stable, 1.0 / plants.distances(gain), np.inf) / (GUARD * peaks)
        worst = int(np.argmax(over))
        excess = max(1.0, float(over[worst]))
        if density is None:
            return excess, -float(changes["controller.bandwidth_hz"]), worst
        return excess, float(np.max(plants.residual_n(gain, density))), worst

    tried = [(judged(each), each) for each in _candidates(system)]
    (excess, _, case), best = min(tried, key=lambda found: found[0][:2])
    if excess > 1.0:
        _, off, peak = cases[case]
        where = f"with the resonance {off:+.0%} off" if off else "with the resonance as described"
        limit = "the resonance is the limit" if off else "delay and lags of the loop are the limit"
        raise FrictionloopError(
            f"sensitivity_peak = {limits[0.0]:g}: no bandwidth of law {kind} holds it; the best, "
            f"{best['controller.bandwidth_hz']:.4g} Hz, gets to Ms {excess * GUARD * peak:.3g} where "
            f"{peak:.3g} is asked, {where}; {limit}"
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
