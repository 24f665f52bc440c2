"""Operating points whose force sensor resonates a little elsewhere than was believed, as responses on one grid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictionloop.analysis.elements import linearise_stages
from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.margins import search_grid
from frictionloop.analysis.sampled import sample
from frictionloop.analysis.state_space import Array, Complex
from frictionloop.control.notch import Section, section_response
from frictionloop.design.pi_region import PiRegion
from frictionloop.parameters import SuspendedSensor
from frictionloop.quantities import FrictionloopError

LOWEST = 1e-4
"""Lowest frequency of a grid over half the rate: 0.25 Hz at 5 kHz, where the integral has all loops in hand."""
_WIDTHS = np.sinh(np.linspace(-4.0, 4.0, 41))
"""Distances from a resonance in half widths."""


def detuned(loop: LinearLoop, factor: float) -> LinearLoop:
    """Return a loop at the same operating point whose sensor resonates at ``factor`` times its frequency."""
    sensor = loop.system.sensor
    if not isinstance(sensor, SuspendedSensor):
        raise FrictionloopError(
            f"sensor.kind = {sensor.kind!r}: has no resonance for a notch, which needs 'suspended'; retune does without"
        )
    system = loop.system.evolve({"sensor.resonance_hz": factor * sensor.resonance_hz})
    there = replace(loop.elements, stages=linearise_stages(system.sensor))
    return LinearLoop(system, there, sample(there, loop.plant.period_s))


def stiffened(loop: LinearLoop) -> LinearLoop:
    """Return the loop at the same operating point with springs that follow at once."""
    there = replace(loop.elements, stages=loop.elements.stages[-1:])
    return LinearLoop(loop.system, there, sample(there, loop.plant.period_s))


@dataclass(frozen=True, eq=False)
class Plants:
    """Force command to measured force of several loops, at frequencies shared by all."""

    frequency_hz: Array
    responses: Complex
    """Shape (loops, frequencies)."""
    integral: Complex
    """Ts/(z - 1)."""
    rate_hz: float

    @classmethod
    def of(cls, loops: Sequence[LinearLoop], overdrive: bool, fine: bool = False) -> Plants:
        """Return the responses, behind overdrive if it is on; ``fine`` has the grid of `LinearLoop.margins`."""
        period_s = loops[0].plant.period_s
        frequency = _fine_grid(loops) if fine else _grid(loops)
        responses = np.array([loop.plant.response(frequency)[:, 1, 0] for loop in loops])
        turn = 2j * np.pi * period_s * frequency
        if overdrive:
            decay = np.exp(-2.0 * np.pi * loops[0].system.controller.model.plate_hz * period_s)
            responses = responses * (1.0 - decay * np.exp(-turn)) / (1.0 - decay)
        return cls(frequency, responses, np.asarray(period_s / np.expm1(turn)), 1.0 / period_s)

    def behind(self, section: Section) -> Plants:
        """Return the plants behind one section of a filter."""
        return replace(self, responses=self.responses * section_response(section, self.frequency_hz, self.rate_hz))

    def regions(self, peaks: Sequence[float]) -> list[PiRegion]:
        """Return which gains keep each loop's Ms."""
        return [PiRegion(response, self.integral, peak) for response, peak in zip(self.responses, peaks, strict=True)]

    def returned(self, kp: float, ki: float) -> Complex:
        """Return 1 + G for PI gains, shape (loops, frequencies)."""
        return np.asarray(1.0 + (kp + ki * self.integral) * self.responses)

    def stable(self, kp: float, ki: float) -> bool:
        """Return whether every loop is stable: 1 + G of a stable plant under PI does not turn around 0 (Nyquist)."""
        phase = np.unwrap(np.angle(self.returned(kp, ki)), axis=1)
        # From -90 degrees, where the integral rules, to 0 at half the rate; each turn is two unstable poles.
        return bool(np.all(np.abs(phase[:, -1]) < 1.0))

    def kp_limit(self) -> float:
        """Return the least kp that takes a loop to -1 without integral."""
        real, imaginary = self.responses.real, self.responses.imag
        crossing = (imaginary[:, 1:] >= 0.0) != (imaginary[:, :-1] >= 0.0)
        at = np.concatenate([real[:, 1:][crossing], real[:, -1]])
        return float(1.0 / -np.min(at))


def _grid(loops: Sequence[LinearLoop]) -> Array:
    nyquist = loops[0].nyquist_hz
    sensors = {loop.system.sensor for loop in loops}
    near = [s.resonance_hz * (1.0 + _WIDTHS / (2.0 * s.q)) for s in sensors if isinstance(s, SuspendedSensor)]
    inside = np.concatenate(near)
    inside = inside[(inside > LOWEST * nyquist) & (inside < nyquist)]
    return np.union1d(np.append(np.geomspace(LOWEST, 1.0, 160), np.linspace(0.02, 1.0, 60)) * nyquist, inside)


def _fine_grid(loops: Sequence[LinearLoop]) -> Array:
    nyquist = loops[0].nyquist_hz
    sensors = {loop.system.sensor for loop in loops}
    around = [(s.resonance_hz, s.resonance_hz / (2.0 * s.q)) for s in sensors if isinstance(s, SuspendedSensor)]
    return np.append(search_grid(nyquist, loops[0].plant.whole_periods, LOWEST * nyquist, around), nyquist)
