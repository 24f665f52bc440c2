"""The corners of the operating grid, how near the loop comes to instability there, and the same by place."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from frictionloop.analysis.linear import LinearLoop, condition_of, linearise
from frictionloop.analysis.margins import Margins
from frictionloop.analysis.stability import NEAR, rings
from frictionloop.analysis.state_space import StateSpace
from frictionloop.design.operating_grid import ITSELF, OperatingGrid, at_place
from frictionloop.design.plant_set import Plants, detuned, laws_on
from frictionloop.findings import Condition, Finding
from frictionloop.loop.progress import step
from frictionloop.parameters import Skin, Strokes, System
from frictionloop.quantities import Array, Complex, FrictionloopError

MET = 1e-3
"""Share by which Ms may be beyond a limit: the accuracy of the searches."""
CLOSE = 1.05
"""Loops whose Ms on a coarse grid is within this factor of the largest are looked at closely."""


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


def peak_of(system: System) -> float:
    """Return the largest Ms over the forces asked for, on a dry and a moist finger; NaN without a linear analysis."""
    try:
        return rings(system).sensitivity_peak
    except FrictionloopError:
        return math.nan


def at_mean(system: System, off: float = 0.0) -> LinearLoop:
    """Return the loop at the mean force on a dry finger, the resonance off by a share."""
    loop = linearise(system)
    return detuned(loop, 1.0 + off) if off else loop


def corners(system: System, grid: OperatingGrid = ITSELF, states: Sequence[float] = ()) -> list[Corner]:
    """Return Ms of a System's controller at the loops of a grid, the resonance off too.

    Sensor, delay, gain and other values are off as well by what its ``lean`` says. A law does not change with
    any of this, so it is made once per place, force and finger.

    The largest Ms of each contact, speed, finger and resonance is exact, and so is any near it; others are those of a
    grid of frequencies, which passes -1 half a step beside the nearest point at most: they are too small, if anything.

    Raises
    ------
    FrictionloopError
        A law that has no linear analysis there.
    """
    cases = cases_of(system, grid, states=states)
    step(f"{len(cases)} loops there")
    _, found = rough_corners(cases)
    groups: dict[tuple[Condition, bool, float], list[int]] = {}
    for k, (loop, off, _) in enumerate(cases):
        at = replace(condition_of(loop.system), load_n=None)
        groups.setdefault((at, loop.elements.occluded > 0.0, off), []).append(k)
    peaks = np.array([each.sensitivity_peak for each in found])
    close = [k for group in groups.values() for k in group if peaks[group].max() <= CLOSE * peaks[k] < np.inf]
    for count, k in enumerate(close, 1):
        step(f"loop {count} of the worst {len(close)}, {condition_of(found[k].loop.system)}")
        found[k] = found[k]._replace(sensitivity_peak=found[k].loop.sensitivity_peak())
    return found


def rough_corners(cases: Sequence[tuple[LinearLoop, float, float]]) -> tuple[Plants, list[Corner]]:
    """Return the loops of `cases_of` on one grid of frequencies, and Ms of each there."""
    loops = [loop for loop, _, _ in cases]
    plants = Plants.of(loops, fine=False)
    stable = np.array([loop.is_stable() for loop in loops])
    peaks = np.where(stable, 1.0 / plants.distances(laws_on(plants.frequency_hz, loops)), np.inf)
    return plants, [
        Corner(off, limit, loop, float(peak)) for (loop, off, limit), peak in zip(cases, peaks, strict=True)
    ]


def cases_of(
    system: System,
    grid: OperatingGrid,
    looked_at: Callable[[LinearLoop], bool] | None = None,
    states: Sequence[float] = (),
) -> list[tuple[LinearLoop, float, float]]:
    """Return the loops of `corners` with their laws, how far the resonance is off, and the largest Ms there.

    Only loops that ``looked_at`` takes are among them; no law is made for others.
    """
    laws: dict[tuple[Condition, float, float], StateSpace] = {}
    found = []
    for loop, off, limit in grid.cases(system, states):
        if looked_at is not None and not looked_at(loop):
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


FASTER = (1.0, 4.0)
"""Speeds that a design is looked at, over that of its strokes: 20 and 80 mm/s, as in the comparison of laws."""
SLOWER = 0.5
"""Speed over the slowest held that is looked at too: a finger that strokes passes every slower speed (assumed)."""
How = Literal["unstable", "near", "beyond", "within"]
"""How a controller does at a place: Ms above `NEAR` is near, beyond its limit is beyond."""


class Place(NamedTuple):
    """A slip length, and a speed or a range of speeds."""

    slip_length_um: float | None
    """None without a skin."""
    speeds_mm_s: tuple[float, ...]
    """Rising, all held to the same limits; none without strokes."""
    corners: tuple[Corner, ...]

    @classmethod
    def of(cls, found: Sequence[Corner]) -> Place:
        """Return the place of corners at one slip length."""
        systems = [each.loop.system for each in found]
        speeds = {each.motion.speed_mm_s for each in systems if isinstance(each.motion, Strokes)}
        finger = systems[0].finger
        return cls(finger.slip_length_um if isinstance(finger, Skin) else None, tuple(sorted(speeds)), tuple(found))

    @property
    def worst(self) -> Corner:
        """The corner farthest beyond its limit; of unstable ones that with the smallest error of the resonance."""
        rings = [each for each in self.corners if math.isinf(each.sensitivity_peak)]
        return min(rings, key=lambda each: abs(each.off)) if rings else max(self.corners, key=lambda each: each.excess)

    @property
    def how(self) -> How:
        """How the controller does there."""
        worst = self.worst
        if math.isinf(worst.sensitivity_peak):
            return "unstable"
        if broken(self.corners) is None:
            return "within"
        return "near" if worst.sensitivity_peak > NEAR else "beyond"

    @property
    def condition(self) -> Condition:
        """Where that is."""
        ends = dict.fromkeys((*self.speeds_mm_s[:1], *self.speeds_mm_s[-1:]))
        speed = next(iter(ends), None) if len(ends) < 2 else tuple(ends)
        return Condition(slip_length_um=self.slip_length_um, speed_mm_s=speed)

    def peak_at(self, off: float) -> float:
        """Return the largest Ms with the resonance off by a share."""
        return max(each.sensitivity_peak for each in self.corners if each.off == off)

    def to_dict(self) -> dict[str, Any]:
        """Return it by name."""
        offs = sorted({each.off for each in self.corners})
        peaks = [{"resonance_off": off, "sensitivity_peak": self.peak_at(off)} for off in offs]
        return {**self.condition.values, "how": self.how, "worst": self.worst, "peaks": peaks}


def elsewhere(
    system: System, grid: OperatingGrid = ITSELF, lengths_um: tuple[float, ...] | None = None
) -> tuple[tuple[Place, ...], tuple[Finding, ...]]:
    """Return how a System's controller does besides the slip lengths and the speeds at which it has to hold.

    That is at both ends of the lengths, from 0 if none are named, at the speed of its strokes, four times that and
    half of it; with a range of speeds also at its ends. It is pressed with each of the loads. Second are findings of
    the places that cannot be looked at.
    """
    places, unseen = [], []
    for changes in strokes_of(system, grid.speeds_mm_s, lengths_um):
        try:
            there = at_place(system, changes)
            if not _among(there, system, grid):
                places.append(Place.of(corners(there, grid._replace(slip_lengths_um=(), speeds_mm_s=()))))
        except FrictionloopError as error:  # no such stroke, a force out of reach, a law that is saturated there
            where = Condition(**{path.split(".")[1]: value for path, value in changes.items()})
            unseen.append(Finding("PLACE-UNSEEN", where=where, more={"reason": str(error)}))
    return tuple(places), tuple(unseen)


def strokes_of(
    system: System, speeds_mm_s: Sequence[float] = (), lengths_um: tuple[float, ...] | None = None
) -> list[dict[str, Any]]:
    """Return overrides for the slip lengths and speeds that are looked at, the longest first.

    None without a skin; no slower speed at which the controller would hold its output.
    """
    if not isinstance(system.finger, Skin):
        return []
    lengths, motion = OperatingGrid(lengths_um).lengths_of(system), system.motion
    if not isinstance(motion, Strokes):
        return [{"finger.slip_length_um": z} for z in lengths]
    usual = motion.speed_mm_s
    speeds = {usual * faster for faster in FASTER} | ({min(speeds_mm_s), max(speeds_mm_s)} if speeds_mm_s else set())
    slowest = SLOWER * min(speeds_mm_s, default=usual)
    speeds |= {slowest} if slowest >= system.touch.load.least_speed_mm_s else set()
    return [{"finger.slip_length_um": z, "motion.speed_mm_s": v} for z in lengths for v in sorted(speeds)]


def _among(there: System, system: System, grid: OperatingGrid) -> bool:
    """Tell whether a place has a slip length and a speed at which the controller of a system was held."""
    if isinstance(there.finger, Skin) and there.finger.slip_length_um not in grid.lengths_of(system):
        return False
    if not (isinstance(there.motion, Strokes) and isinstance(system.motion, Strokes)):
        return True
    speeds = grid.speeds_mm_s or (system.motion.speed_mm_s,)
    return min(speeds) <= there.motion.speed_mm_s <= max(speeds)


Group = tuple[float, float]
"""Share by which the resonance is off, and how far occlusion has come."""


def worst_margins(found: Sequence[Corner]) -> dict[Group, list[Margins]]:
    """Return the margins of the worst loops of each resonance and finger: the least of each margin is among them.

    A grid of frequencies that all loops share tells which loops these are, where they differ by more than a percent;
    their margins are exact.
    """
    loops = [each.loop for each in found]
    step(f"margins of {len(loops)} loops")
    plants = Plants.of(loops, fine=False)
    gains = laws_on(plants.frequency_hz, loops) * plants.responses
    rough = np.array([_rough(plants.frequency_hz, gain) for gain in gains])
    rough = np.column_stack([rough, [1.0 / each.sensitivity_peak for each in found]])
    groups: dict[Group, list[int]] = {}
    for k, each in enumerate(found):
        groups.setdefault((each.off, each.loop.elements.occluded), []).append(k)
    picked = {at: dict.fromkeys(group[k] for k in np.argmin(rough[group], axis=0)) for at, group in groups.items()}
    return {at: [loops[k].margins() for k in some] for at, some in picked.items()}


def _rough(frequency_hz: Array, gain: Complex) -> tuple[float, float, float]:
    """Return how near G comes to -1 in gain (|ln|), in phase (rad) and in delay (s), straight between frequencies."""
    frequency, at_unity = _between(frequency_hz, gain, np.abs(gain) - 1.0)
    phase = np.angle(-at_unity)
    delay_s = np.mod(phase, 2.0 * np.pi) / (2.0 * np.pi * np.maximum(frequency, np.finfo(float).tiny))
    _, real = _between(frequency_hz, gain, gain.imag)
    negative = np.append(real.real, gain[-1].real)  # real at half the control rate
    negative = negative[negative < 0.0]
    least = [np.abs(np.log(-negative)), np.abs(phase), delay_s]
    ends = [float(np.min(each)) if each.size else math.inf for each in least]
    return ends[0], ends[1], ends[2]


def _between(frequency_hz: Array, gain: Complex, value: Array) -> tuple[Array, Complex]:
    """Return frequencies and G where a real value along it changes its sign."""
    k = np.flatnonzero((value[1:] >= 0.0) != (value[:-1] >= 0.0))
    share = value[k] / (value[k] - value[k + 1])
    return frequency_hz[k] + share * (frequency_hz[k + 1] - frequency_hz[k]), gain[k] + share * (gain[k + 1] - gain[k])
