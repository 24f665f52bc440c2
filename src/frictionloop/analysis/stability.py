"""Whether a loop rings, where, and up to which proportional gain it is stable."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from frictionloop.analysis.law_space import pi_space
from frictionloop.analysis.linear import LinearLoop, check_pi, condition_of, linearise, operating_band
from frictionloop.analysis.margins import real_axis
from frictionloop.analysis.operating_point import at_levels, occlusions
from frictionloop.analysis.state_space import close
from frictionloop.findings import Condition, Finding
from frictionloop.parameters import PiController, SuspendedSensor, System
from frictionloop.quantities import Array, Complex, FrictionloopError

LOWEST_HZ = 5.0
"""Ringing is above the tracking of a set-point (chosen)."""
NEAR = 4.0
"""Ms above which a loop is said to be near instability: less than 0.25 from -1, a phase margin below 15 degrees."""
LARGEST = 2.0
"""Ms that is asked for where nobody asks for another: a phase margin of at least 29 degrees."""
OPEN = frozenset({"lookup"})
"""Laws that close no loop."""


@dataclass(frozen=True, kw_only=True)
class Ringing:
    """How near the linear loop comes to instability, over forces and states of the finger."""

    how: Literal["unstable", "near", "calm"]
    """``near``: Ms above `NEAR`."""
    sensitivity_peak: float
    """Largest Ms; infinite where a loop is unstable."""
    frequency_hz: float | None
    """Of the least damped pole above 5 Hz; None if none oscillates."""
    dry: bool
    """Whether a finger just landed is as near to it, and not a moist one alone."""
    where: Condition
    """The worst loop; of unstable ones on a finger just landed, if it is unstable there."""

    @property
    def stable(self) -> bool:
        """Whether no loop is unstable."""
        return self.how != "unstable"

    @property
    def finding(self) -> Finding | None:
        """That it is unstable, or close to it."""
        if self.how == "calm":
            return None
        if self.how == "near":
            return Finding("LOOP-NEAR", value=self.sensitivity_peak, limit=LARGEST, where=self.where)
        return Finding("LOOP-UNSTABLE", "error", self.frequency_hz, unit="Hz", where=self.where)


def rings(system: System, occluded: Sequence[float] = (), resonance_off: float = 0.0) -> Ringing:
    """Return whether a loop rings: lowest, mean and highest force asked for, by state of the finger.

    Parameters
    ----------
    system
        The loop; of recorded signals their levels count (`at_levels`).
    occluded
        States of the finger, 0 to 1; just landed and moist after its contacts if not given.
    resonance_off
        Share by which the sensor's resonance is off; a sensor without one stays as it is.

    Raises
    ------
    FrictionloopError
        A law or a place without a linear analysis.
    """
    system, sensor = at_levels(system), system.sensor
    if resonance_off and isinstance(sensor, SuspendedSensor):
        system = system.evolve({"sensor.resonance_hz": (1.0 + resonance_off) * sensor.resonance_hz})
    loops = operating_band(system, occluded=occluded or occlusions(system))
    peaks = [loop.sensitivity_peak() for loop in loops]
    worst = max(peaks)
    how: Literal["unstable", "near", "calm"] = (
        "calm" if worst < NEAR else "near" if math.isfinite(worst) else "unstable"
    )
    least = min(loop.elements.occluded for loop in loops)
    alike = [k for k, peak in enumerate(peaks) if peak == worst or (how == "near" and peak >= NEAR)]
    landed = [k for k in alike if loops[k].elements.occluded == least]
    at = loops[max(landed or alike, key=lambda k: peaks[k])].elements
    return Ringing(
        how=how,
        sensitivity_peak=worst,
        frequency_hz=ringing_hz(loops),
        dry=bool(landed),
        where=replace(
            condition_of(system), force_n=at.force_n, occluded=at.occluded or None, resonance_off=resonance_off or None
        ),
    )


def rings_if_linear(system: System, resonance_off: float = 0.0) -> Ringing | None:
    """Return `rings` before a plate is driven, of a PI up to full moisture; None of a loop without linear analysis."""
    moist = (0.0, 1.0) if isinstance(system.controller, PiController) else ()
    try:
        return rings(system, moist, resonance_off)
    except FrictionloopError:
        return None


def ringing_hz(loops: Sequence[LinearLoop]) -> float | None:
    """Return the frequency of the oscillating pole that is the least damped of all loops; None if none oscillates."""
    poles = [
        (float(abs(pole)), float(abs(np.angle(pole)) / (2 * np.pi * loop.plant.period_s)))
        for loop in loops
        for pole in loop.poles()
    ]
    return max(((size, at_hz) for size, at_hz in poles if at_hz > LOWEST_HZ), default=(0.0, None))[1]


def kp_limit(system: System | LinearLoop) -> float:
    """Return the largest kp with which the sampled loop is stable, its ki, rate and delay kept; NaN if none is.

    A closed-loop pole sits on the unit circle where 1 + (kp + ki Ts / (z - 1)) P S(z) = 0, so every limit is a
    real, positive value of q(z) = -1 / P S(z) - ki Ts / (z - 1), |z| = 1. Between two limits stability does not change:
    one look at the poles decides, from kp = 0 upwards until the first stable stretch, whose end is returned.

    Parameters
    ----------
    system
        The loop (at the operating point of `linearise`), or its `LinearLoop` at another one.

    Raises
    ------
    FrictionloopError
        For what is neither, an operating point that cannot be reached, or a law that has no kp.
    """
    loop = system if isinstance(system, LinearLoop) else linearise(system)
    plant, ki, limits = loop.plant.state_space(), check_pi(loop.system).ki, _limits(loop)
    for low, high in zip([0.0, *limits], limits, strict=False):
        if close(plant, pi_space((low + high) / 2, ki, plant.period_s)).is_stable():
            return float(high)
    return math.nan


def _limits(loop: LinearLoop) -> Array:
    """Return every kp > 0 that puts a closed-loop pole on the unit circle, rising."""
    step = check_pi(loop.system).ki * loop.plant.period_s

    def limit(frequency: Array) -> Complex:
        turn = 2j * np.pi * frequency * loop.plant.period_s
        return np.asarray(-1.0 / loop.plant.response(frequency)[:, 1, 0] - step / np.expm1(turn))

    grid = loop.search_grid()
    values = limit(real_axis(limit, grid, limit(grid), loop.nyquist_hz)).real
    return np.unique(values[values > 0])
