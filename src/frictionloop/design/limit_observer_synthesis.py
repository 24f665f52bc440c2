"""The limit observer within margins: what it is made to believe of the sensor, for all slip lengths and speeds.

A believed resonance below the true one, broad, and a slow pole make an observer that bears a resonance that is off
(docs/will-it-ring.md). These three, and how much its springs are driven, are those with the least residual of
friction noise on the finger of the bench, within the limits on Ms on one `susceptibility_margin` times as
susceptible.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from frictionloop.analysis.disturbance_spectrum import touch_spectrum
from frictionloop.analysis.law_space import law_space
from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.loop_elements import linearise_contact
from frictionloop.design.grid_corners import FASTER, broken, corners
from frictionloop.design.plant_set import Plants, shifted
from frictionloop.design.requirements import Designed, Requirements, unheld
from frictionloop.parameters import Strokes, SuspendedSensor, System
from frictionloop.quantities import Array, Complex, FrictionloopError

GUARD = 0.985
"""Share of a limit on Ms that is used: |S| is looked at on a grid, and forces in between are not."""
PENALTY, TRIES = 3.0, 150
"""Of an excess of Ms by its limit's size, in the logarithm of the residual, and most beliefs tried (chosen)."""
BORNE = 1.35
"""Loop gain that a design which holds its limits at 1 bears with Ms below 2.9 (studies/as_it_runs)."""
AT_MARGIN = {"controller.susceptibility_margin": 1.0}
"""The loop of a finger that is as much more susceptible as the law allows for: its loop gain is 1."""


class Belief(NamedTuple):
    """What is searched, each as a share of what is so; the last as it is."""

    resonance: float = 0.91
    q: float = 0.5
    pole: float = 0.75
    spring_noise: float = 0.5

    def overrides_on(self, system: System) -> dict[str, Any]:
        """Return overrides of a limit observer on a bench."""
        sensor: Any = system.sensor
        return {
            "controller.kind": "limit_observer",
            "controller.spring_noise": float(f"{self.spring_noise:.4g}"),
            "controller.model.resonance_hz": float(f"{self.resonance * sensor.resonance_hz:.4g}"),
            "controller.model.resonance_q": float(f"{self.q * sensor.q:.4g}"),
            "controller.model.sensor_hz": float(f"{self.pole * sensor.cutoff_hz:.4g}"),
        }


@dataclass(frozen=True, eq=False)
class Search:
    """Loops of all slip lengths, and what of friction noise a belief leaves there."""

    loops: list[LinearLoop]
    plants: Plants
    """Each with a gain of 1 at low frequencies."""
    peaks: Array
    """Largest Ms of each loop."""
    plain: Array
    """Which loops have the resonance as described."""
    density: Array
    """Friction noise behind each loop's contact, N^2/Hz."""

    @classmethod
    def of(cls, system: System, wanted: Requirements) -> Search:
        """Return the search for a bench."""
        cases = shifted(_loops(system, wanted), wanted.limits)
        loops = [loop for loop, _, _ in cases]
        plants = Plants.of(loops)
        contacts = [linearise_contact(loop.system, loop.elements.force_n) for loop in loops]
        noise = [
            touch_spectrum(loop.system, 0.0)(plants.frequency_hz) * np.abs(contact.response(plants.frequency_hz)) ** 2
            for loop, contact in zip(loops, contacts, strict=True)
        ]
        return cls(
            loops,
            replace(plants, responses=plants.responses / np.array([[_gain(loop)] for loop in loops])),
            GUARD * np.array([peak for _, _, peak in cases]),
            np.array([off == 0.0 for _, off, _ in cases]),
            np.array(noise),
        )

    def response(self, told: Mapping[str, Any]) -> Complex:
        """Return the law at each loop, of loop gain 1: it is the same at every force, and one at each speed."""
        found: dict[float, Complex] = {}
        for loop in sorted(self.loops, key=lambda each: each.elements.occluded):
            if (speed := _speed(loop)) not in found:
                law = law_space(loop.system.evolve({**told, **AT_MARGIN}), loop.elements, loop.plant)
                found[speed] = -_gain(loop) * law.response(self.plants.frequency_hz)[:, 1, 1]
        return np.array([found[_speed(loop)] for loop in self.loops])

    def cost(self, system: System, belief: Belief) -> float:
        """Return the mean logarithm of the residual, and what Ms is beyond its limits."""
        controller: Any = system.controller
        told = belief.overrides_on(system)
        try:
            law = self.response(told)
        except FrictionloopError:
            return 1e3
        over = np.maximum(np.minimum(self.plants.peaks(law), 50.0) / self.peaks - 1.0, 0.0)
        returned = self.plants.returned(law / controller.susceptibility_margin)
        left = np.trapezoid(self.density / np.abs(returned) ** 2, self.plants.frequency_hz, axis=1)
        return float(np.mean(0.5 * np.log(left[self.plain])) + PENALTY * np.sum(over))

    def best(self, system: System) -> Belief:
        """Return the belief of least cost (Nelder and Mead)."""
        start = np.log(np.array(Belief()))
        simplex = start + np.vstack([np.zeros(4), np.diag([0.03, 0.4, 0.2, 0.4])])
        options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-4, "maxfev": TRIES}
        found = minimize(
            lambda x: self.cost(system, Belief(*np.exp(x).tolist())), start, method="Nelder-Mead", options=options
        )
        return Belief(*np.exp(found.x).tolist())


def _gain(loop: LinearLoop) -> float:
    """Return the force per command of a loop at low frequencies."""
    plate = loop.elements.plate
    return float(plate.num[-1] / plate.den[-1])


def _speed(loop: LinearLoop) -> float:
    motion: Any = loop.system.motion
    return float(motion.speed_mm_s)


def _loops(system: System, wanted: Requirements) -> list[LinearLoop]:
    """Return loops at forces, moistures and speeds, at both ends of the slip length."""
    plain = system.evolve({"controller.kind": "pi"})
    grid = wanted.grid()
    if not grid.speeds_mm_s:
        motion: Any = system.motion
        grid = grid._replace(speeds_mm_s=tuple(motion.speed_mm_s * faster for faster in FASTER))
    return grid.loops(plain)


def limit_observer(system: System, wanted: Requirements) -> Designed:
    """Limit observer of least residual, its limits held up to a loop gain of 1.

    Raises
    ------
    FrictionloopError
        A bench without springs under its sensor, or margins that it cannot hold: the line says where.
    """
    if not isinstance(system.sensor, SuspendedSensor):
        raise FrictionloopError(f'sensor.kind = "{system.sensor.kind}": must be "suspended"')
    if not (isinstance(system.motion, Strokes) and hasattr(system.friction, "susceptibility_per_um2")):
        raise FrictionloopError("limit_observer: needs strokes")
    margin = float(f"{max(wanted.gain_of(system) / BORNE, 1.0):.3g}")
    own = {"controller.kind": "limit_observer", "controller.susceptibility_margin": margin}
    there = system.evolve(own)  # a delay that does not fit is refused here
    found = own | Search.of(there, wanted).best(there).overrides_on(system)
    worst = broken(corners(system.evolve({**found, **AT_MARGIN}), wanted.grid()))
    if worst is not None:
        raise unheld("limit_observer", wanted, worst)
    return Designed(found)
