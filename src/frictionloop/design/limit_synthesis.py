"""The limit observer within margins: what it is made to believe of the sensor, for all slip lengths and speeds.

A believed resonance below the true one, broad, and a slow pole make an observer that bears a resonance that is off
(studies/pages/beliefs.md). These three, and how much its springs are driven, are those with the least residual of
friction noise within the limits on Ms, at the loop gain that there is and at the largest (`largest_gain`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from frictionloop.analysis.disturbance import touch_spectrum
from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.state_space import Array, Complex
from frictionloop.design.corners import Corner, band_of, broken, corners
from frictionloop.design.elsewhere import FASTER
from frictionloop.design.limit_linear import compliance_of, knowing, lag_of, largest_gain, small_signals
from frictionloop.design.over import Over
from frictionloop.design.plants import Plants, shifted
from frictionloop.design.wanted import Designed, Wanted, unheld
from frictionloop.parameters import Strokes, SuspendedSensor, System
from frictionloop.quantities import FrictionloopError

GUARD = 0.985
"""Share of a limit on Ms that is used: |S| is looked at on a grid, and forces in between are not."""
PENALTY, TRIES = 3.0, 150
"""Of an excess of Ms by its limit's size, in the logarithm of the residual, and most beliefs tried (chosen)."""


class Belief(NamedTuple):
    """What is searched, each as a share of what is so; the last as it is."""

    resonance: float = 0.91
    q: float = 0.5
    pole: float = 0.75
    spring_noise: float = 0.5

    def told(self, system: System) -> dict[str, Any]:
        """Return overrides of a limit observer on a bench."""
        sensor: Any = system.sensor
        return {
            "controller.kind": "limit_observer",
            "controller.compliance_um_per_n": compliance_of(system),
            "controller.spring_noise": float(f"{self.spring_noise:.4g}"),
            "controller.model.resonance_hz": float(f"{self.resonance * sensor.resonance_hz:.4g}"),
            "controller.model.resonance_q": float(f"{self.q * sensor.q:.4g}"),
            "controller.model.sensor_hz": float(f"{self.pole * sensor.cutoff_hz:.4g}"),
        }


@dataclass(frozen=True, eq=False)
class Search:
    """Loops of all slip lengths, and what of friction noise a belief leaves there."""

    system: System
    plants: Plants
    lags: tuple[float, ...]
    peaks: Array
    """Largest Ms of each loop."""
    plain: Array
    """Which loops have the resonance as described."""
    density: Array
    """Friction noise behind each loop's contact, N^2/Hz."""

    @classmethod
    def of(cls, system: System, wanted: Wanted) -> Search:
        """Return the search for a bench."""
        cases = shifted(_loops(system, wanted), wanted.limits)
        loops = [loop for loop, _, _ in cases]
        plants = Plants.of(loops, overdrive=True)
        gains = np.array([loop.elements.plate.num[-1] / loop.elements.plate.den[-1] for loop in loops])
        lags = tuple(lag_of(loop) for loop in loops)
        turn = 2.0 * math.pi * plants.frequency_hz / plants.rate_hz
        noise = np.array([touch_spectrum(loop.system, 0.0)(plants.frequency_hz) for loop in loops])
        return cls(
            system,
            replace(plants, responses=plants.responses / gains[:, None]),
            lags,
            GUARD * np.array([peak for _, _, peak in cases]),
            np.array([off == 0.0 for _, off, _ in cases]),
            noise / (1.0 + (np.array(lags)[:, None] * turn) ** 2),
        )

    def response(self, belief: Belief) -> Complex:
        """Return the law at each loop."""
        c: Any = self.system.evolve(belief.told(self.system)).controller
        at = {
            lag: small_signals(c.model, c.rate_hz, c.bandwidth_hz, c.spring_noise, lag)
            .response(self.plants.frequency_hz)[:, 0, 0]
            for lag in set(self.lags)
        }  # fmt: skip
        return np.array([at[lag] for lag in self.lags])

    def cost(self, x: Array) -> float:
        """Return the mean logarithm of the residual, and what Ms is beyond its limits."""
        try:
            law = self.response(Belief(*np.exp(x).tolist()))
        except FrictionloopError:
            return 1e3
        over = sum(
            np.sum(np.maximum(np.minimum(self.plants.peaks(gain * law), 50.0) / self.peaks - 1.0, 0.0))
            for gain in {1.0, largest_gain(self.system)}
        )
        left = np.trapezoid(self.density / np.abs(self.plants.returned(law)) ** 2, self.plants.frequency_hz, axis=1)
        return float(np.mean(0.5 * np.log(left[self.plain])) + PENALTY * over)

    def best(self) -> Belief:
        """Return the belief of least cost (Nelder and Mead)."""
        start = np.log(np.array(Belief()))
        simplex = start + np.vstack([np.zeros(4), np.diag([0.03, 0.4, 0.2, 0.4])])
        options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-4, "maxfev": TRIES}
        return Belief(*np.exp(minimize(self.cost, start, method="Nelder-Mead", options=options).x).tolist())


def _loops(system: System, wanted: Wanted) -> list[LinearLoop]:
    """Return loops at forces, moistures and speeds, at both ends of the slip length."""
    plain = system.evolve({"controller.kind": "pi"})
    lengths, speeds, loads = wanted.places
    if not speeds and isinstance(system.motion, Strokes):
        speeds = tuple(system.motion.speed_mm_s * faster for faster in FASTER)
    return band_of(plain, Over(lengths, speeds, loads))


def limit_observer(system: System, wanted: Wanted) -> Designed:
    """Limit observer of least residual, its margins those of the largest loop gain (`largest_gain`).

    Raises
    ------
    FrictionloopError
        A bench without springs under its sensor, or margins that it cannot hold: the line says where.
    """
    if not isinstance(system.sensor, SuspendedSensor):
        raise FrictionloopError(f'sensor.kind = "{system.sensor.kind}": a limit observer needs a "suspended" one')
    if not (isinstance(system.motion, Strokes) and hasattr(system.friction, "susceptibility_per_um2")):
        raise FrictionloopError("system: a limit observer is designed for a finger that strokes")
    system.evolve({"controller.kind": "limit_observer"})  # a delay that does not fit is refused here
    found = Search.of(system, wanted).best().told(system)
    at: list[Corner] = []
    for there in Over(wanted.slip_lengths_um).systems(system.evolve(found)):
        at += corners(knowing(there), wanted.limits, wanted.places._replace(slip_lengths_um=()))
    worst = broken(at)
    if worst is not None:
        raise FrictionloopError(unheld("limit_observer", wanted, worst))
    gain = largest_gain(system)
    said = (
        f"margins are those of a contact that is told, {found['controller.compliance_um_per_n']:g} um/N here, "
        f"and of a loop gain {gain - 1:.0%} above that of a known finger; at the start it is less"
        if gain > 1.0
        else "margins are those of the contact and of the susceptibility that are told; it learns nothing"
    )
    return Designed(found, (said,), tuple(at))
