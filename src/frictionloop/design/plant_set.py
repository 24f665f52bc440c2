"""Several loops without their controllers, as responses on one grid: what a controller does to all of them at once."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from frictionloop.analysis.linear import LinearLoop, resonances
from frictionloop.analysis.margins import gain_roots, search_grid
from frictionloop.analysis.sampled_plant import sample
from frictionloop.analysis.state_space import StateSpace
from frictionloop.parameters import SuspendedSensor, System
from frictionloop.quantities import Array, Complex
from frictionloop.sensing.force_sensor import linearise_sensor

LOWEST = 1e-4
"""Lowest frequency of a grid over half the rate: 0.25 Hz at 5 kHz, where the integral has all loops in hand."""
TINY = float(np.finfo(float).tiny)
"""What a step of no length is divided by."""
_WIDTHS = np.sinh(np.linspace(-4.0, 4.0, 41))
"""Distances from a resonance in half widths."""


def detuned(loop: LinearLoop, factor: float) -> LinearLoop:
    """Return a loop at the same operating point whose sensor resonates at ``factor`` times its frequency."""
    hz = loop.system.sensor.resonance_hz  # type: ignore[union-attr]
    system = loop.system.evolve({"sensor.resonance_hz": factor * hz})
    there = replace(loop.elements, stages=linearise_sensor(system.sensor))
    return LinearLoop(system, there, sample(there, loop.plant.period_s))


def stiffened(loop: LinearLoop) -> LinearLoop:
    """Return the loop at the same operating point with springs that follow at once."""
    there = replace(loop.elements, stages=loop.elements.stages[-1:])
    return LinearLoop(loop.system, there, sample(there, loop.plant.period_s))


def shifted(points: Sequence[LinearLoop], limits: Mapping[float, float]) -> list[tuple[LinearLoop, float, float]]:
    """Return loops with the resonance off either way by what limits on Ms name; as they are without a resonance.

    Returns
    -------
    list of (LinearLoop, float, float)
        Loop, share by which its resonance is off, largest Ms.
    """
    sprung = isinstance(points[0].system.sensor, SuspendedSensor)
    shifts = [(sign * e, peak) for e, peak in limits.items() for sign in ((-1.0, 1.0) if e else (0.0,))]
    return [
        (detuned(point, 1.0 + off) if off else point, off, peak)
        for off, peak in sorted(shifts)
        if sprung or not off
        for point in points
    ]


@dataclass(frozen=True, eq=False)
class Plants:
    """Force command to measured force of several loops, at frequencies shared by all."""

    frequency_hz: Array
    responses: Complex
    """Shape (loops, frequencies)."""
    rate_hz: float

    @classmethod
    def of(cls, loops: Sequence[LinearLoop], overdrive: bool = False, fine: bool = True) -> Plants:
        """Return the responses, behind overdrive if it is on; ``fine`` has the grid of `LinearLoop.margins`."""
        frequency = _fine_grid(loops) if fine else _grid(loops)
        responses = np.array([loop.plant.response(frequency)[:, 1, 0] for loop in loops])
        if overdrive:
            responses = responses * lead(overdrive_decay(loops[0].system), frequency, loops[0].plant.period_s)
        return cls(frequency, responses, 1.0 / loops[0].plant.period_s)

    @cached_property
    def integral(self) -> Complex:
        """Ts/(z - 1)."""
        return np.asarray(1.0 / self.rate_hz / np.expm1(2j * np.pi * self.frequency_hz / self.rate_hz))

    def pi(self, kp: float, ki: float) -> Complex:
        """Return the response of a PI law."""
        return np.asarray(kp + ki * self.integral)

    def behind(self, filter_: Complex) -> Plants:
        """Return the plants behind a filter of this response."""
        return replace(self, responses=self.responses * filter_)

    def some(self, numbers: Sequence[int]) -> Plants:
        """Return the plants of these numbers."""
        return replace(self, responses=self.responses[list(numbers)])

    def returned(self, controller: Complex) -> Complex:
        """Return 1 + G under a controller of this response, shape (loops, frequencies)."""
        return np.asarray(1.0 + controller * self.responses)

    def stable(self, controller: Complex) -> NDArray[np.bool_]:
        """Return which loops are stable: 1 + G of stable plant and law does not turn around 0 (Nyquist).

        The law is stable but for an integrator.
        """
        phase = np.unwrap(np.angle(self.returned(controller)), axis=1)
        # From -90 degrees, where the integral rules, to 0 at half the rate; each turn is two unstable poles.
        # An integral of the wrong sign begins at 90.
        return np.asarray((phase[:, 0] < 1.0) & (np.abs(phase[:, -1]) < 1.0))

    def distances(self, controller: Complex) -> Array:
        """Return the smallest distance of G from -1 in each loop, 1/Ms of a stable one; G goes straight in between."""
        returned = self.returned(controller)
        here, way = returned[:, :-1], np.diff(returned, axis=1)
        share = np.clip(-(here * way.conj()).real / np.maximum(np.abs(way) ** 2, TINY), 0.0, 1.0)
        return np.asarray(np.min(np.abs(here + share * way), axis=1))

    def peaks(self, controller: Complex) -> Array:
        """Return Ms of each loop under a law as for `stable`, infinite where it is unstable."""
        return np.where(self.stable(controller), 1.0 / self.distances(controller), np.inf)

    def residual_n(self, controller: Complex, density: Array) -> Array:
        """Return the rms that S leaves of a disturbance of this density (N^2/Hz) in each loop, N."""
        power = density / np.abs(self.returned(controller)) ** 2
        return np.sqrt(np.trapezoid(power, self.frequency_hz, axis=1))

    def kp_limit(self) -> float:
        """Return the least kp that takes a loop to -1 without integral."""
        real, imaginary = self.responses.real, self.responses.imag
        crossing = (imaginary[:, 1:] >= 0.0) != (imaginary[:, :-1] >= 0.0)
        at = np.concatenate([real[:, 1:][crossing], real[:, -1]])
        return float(1.0 / -np.min(at))


def lead(decay: float, frequency_hz: ArrayLike, period_s: float) -> Complex:
    """Return (1 - p/z)/(1 - p), what overdrive does to a force command for small signals; p = 0 is none."""
    back = np.exp(-2j * np.pi * np.asarray(frequency_hz, dtype=float) * period_s)
    return np.asarray((1.0 - decay * back) / (1.0 - decay))


def overdrive_decay(system: System) -> float:
    """Return the decay p of the believed plate over a period."""
    controller = system.controller
    return math.exp(-2.0 * math.pi * controller.model.plate_hz / controller.rate_hz)


def _grid(loops: Sequence[LinearLoop]) -> Array:
    nyquist = loops[0].nyquist_hz
    inside = np.concatenate([[], *(hz + width * _WIDTHS for hz, width in resonances(loops))])
    inside = inside[(inside > LOWEST * nyquist) & (inside < nyquist)]
    return np.union1d(np.append(np.geomspace(LOWEST, 1.0, 160), np.linspace(0.02, 1.0, 60)) * nyquist, inside)


def _fine_grid(loops: Sequence[LinearLoop]) -> Array:
    nyquist, periods = loops[0].nyquist_hz, loops[0].plant.whole_periods
    return np.append(search_grid(nyquist, periods, LOWEST * nyquist, resonances(loops)), nyquist)


NEAR = 1.02
"""Factors above the least of a coarse grid by less than this are looked at closely: the grid is right within 1 %."""


def least_gain(loops: Sequence[LinearLoop], limits: Sequence[float], plants: Plants | None = None) -> float:
    """Return the least `LinearLoop.gain_factor` of loops with their laws, each with its largest Ms.

    ``plants`` are the loops on a coarse grid where they are known already.
    """
    there = plants or Plants.of(loops, fine=False)
    gains = laws_on(there.frequency_hz, loops) * there.responses
    rough = np.min(gain_roots(gains, np.array(limits)[:, None]), axis=1)
    least = float(np.min(rough))
    near = [k for k, factor in enumerate(rough.tolist()) if factor <= NEAR * least]
    return min(loops[k].gain_factor(limits[k]) for k in near)


def laws_on(frequency_hz: Array, loops: Sequence[LinearLoop]) -> Complex:
    """Return the response of each law from minus the measured force to its command, shape (loops, frequencies)."""
    laws: dict[int, StateSpace] = {id(loop.law): loop.law for loop in loops}  # most loops share theirs
    found = {name: -law.response(frequency_hz)[:, 1, 1] for name, law in laws.items()}
    return np.array([found[id(loop.law)] for loop in loops])
