"""The corners at which a controller has to hold: forces, dry and moist, resonances."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from frictionloop.analysis.band import operating_band
from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.margins import Margins
from frictionloop.analysis.occlusions import occlusions
from frictionloop.analysis.state_space import StateSpace
from frictionloop.design.leaning import Lean, leaning
from frictionloop.design.least_gain import laws_on
from frictionloop.design.over import ITSELF, Over
from frictionloop.design.plants import Plants, detuned, shifted
from frictionloop.findings import Condition
from frictionloop.loop.progress import step
from frictionloop.parameters import Skin, Strokes, System

MET = 1e-3
"""Share by which Ms may be beyond a limit: the accuracy of the searches."""
CLOSE = 1.05
"""Loops whose Ms on a coarse grid is within this factor of the largest are looked at closely."""
NOTHING = Lean()


class Corner(NamedTuple):
    """One loop, and how near it comes to instability."""

    off: float
    """Share by which the resonance is off."""
    limit: float
    """Largest Ms there."""
    loop: LinearLoop
    sensitivity_peak: float
    """Ms, infinite if the loop is unstable."""

    @property
    def margins(self) -> Margins:
        """All margins of the loop, which take longer to find."""
        return self.loop.margins()

    @property
    def condition(self) -> Condition:
        """Where that is."""
        found = self.loop.elements
        place = condition_of(self.loop.system)
        return replace(place, force_n=found.force_n, occluded=found.occluded, resonance_off=self.off or None)

    @property
    def excess(self) -> float:
        """Return Ms over the largest one."""
        return self.sensitivity_peak / self.limit

    def to_dict(self) -> dict[str, Any]:
        """Return it by name."""
        return {**self.condition.values, "sensitivity_peak": self.sensitivity_peak, "limit": self.limit}


def band_of(system: System, over: Over = ITSELF, states: Sequence[float] = ()) -> list[LinearLoop]:
    """Return the loops at lowest, mean and highest force asked for, at each place, by states of the finger.

    Without any these are `occlusions`.
    """
    return [
        loop for there in over.systems(system) for loop in operating_band(there, occluded=states or occlusions(there))
    ]


def condition_of(system: System) -> Condition:
    """Return at which slip length, speed and load a loop is linearised."""
    finger, motion = system.finger, system.motion
    found = Condition(slip_length_um=finger.slip_length_um if isinstance(finger, Skin) else None)
    return replace(found, speed_mm_s=motion.speed_mm_s, load_n=motion.load_n) if isinstance(motion, Strokes) else found


def load_of(system: System) -> float | None:
    """Return the mean load of a finger that strokes, N; None of any other."""
    return system.motion.load_n if isinstance(system.motion, Strokes) else None


def at_mean(system: System, off: float = 0.0) -> LinearLoop:
    """Return the loop at the mean force on a dry finger, the resonance off by a share."""
    loop = linearise(system)
    return detuned(loop, 1.0 + off) if off else loop


def corners(
    system: System,
    limits: Mapping[float, float],
    over: Over = ITSELF,
    lean: Lean = NOTHING,
    states: Sequence[float] = (),
) -> list[Corner]:
    """Return Ms of a System's controller at its `band_of`, the resonance off too.

    Sensor, delay, gain and other values are off as well by what ``lean`` says (`leaning`). A law does not change with
    any of this, so it is made once per place, force and finger.

    The largest Ms of each contact, speed, finger and resonance is exact, and so is any near it; others are those of a
    grid of frequencies, which passes -1 half a step beside the nearest point at most: they are too small, if anything.

    Raises
    ------
    FrictionloopError
        A law that has no linear analysis there.
    """
    cases = cases_of(system, limits, over, lean, states=states)
    step(f"{len(cases)} loops there")
    loops = [loop for loop, _, _ in cases]
    plants = Plants.of(loops, fine=False)
    stable = np.array([loop.is_stable() for loop in loops])
    peaks = np.where(stable, 1.0 / plants.distances(laws_on(plants.frequency_hz, loops)), np.inf)
    groups: dict[tuple[Condition, bool, float], list[int]] = {}
    for k, (loop, off, _) in enumerate(cases):
        at = replace(condition_of(loop.system), load_n=None)
        groups.setdefault((at, loop.elements.occluded > 0.0, off), []).append(k)
    close = [k for group in groups.values() for k in group if peaks[group].max() <= CLOSE * peaks[k] < np.inf]
    for count, k in enumerate(close, 1):
        step(f"loop {count} of the worst {len(close)}, {condition_of(loops[k].system)}")
        peaks[k] = loops[k].sensitivity_peak()
    return [Corner(off, limit, loop, float(peak)) for (loop, off, limit), peak in zip(cases, peaks, strict=True)]


def _any(_: LinearLoop) -> bool:
    return True


def cases_of(
    system: System,
    limits: Mapping[float, float],
    over: Over = ITSELF,
    lean: Lean = NOTHING,
    looked_at: Callable[[LinearLoop], bool] = _any,
    states: Sequence[float] = (),
) -> list[tuple[LinearLoop, float, float]]:
    """Return the loops of `corners` with their laws, how far the resonance is off, and the largest Ms there.

    Only loops that ``looked_at`` takes are among them; no law is made for others.
    """
    laws: dict[tuple[Condition, float, float], StateSpace] = {}
    found = []
    for loop, off, limit in shifted(leaning(band_of(system, over, states), lean), limits):
        if not looked_at(loop):
            continue
        at = (condition_of(loop.system), loop.elements.force_n, loop.elements.occluded)
        if at not in laws:
            laws[at] = loop.law
        found.append((replace(loop, known_law=laws[at]), off, limit))
    return found


def broken(found: Sequence[Corner]) -> Corner | None:
    """Return the corner farthest beyond its limit, None if all hold."""
    worst = max(found, key=lambda each: each.excess)
    return worst if worst.excess > 1.0 + MET else None
