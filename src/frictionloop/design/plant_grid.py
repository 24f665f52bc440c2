"""The plants a controller may meet, resonance, gain, contact and speed off, kept to judge many controllers on them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.state_space import Array, Complex
from frictionloop.design.noise_model import NoiseModel
from frictionloop.design.nyquist import poles_outside
from frictionloop.parameters import LowpassSensor, Skin, Strokes, System, check_system
from frictionloop.quantities import FrictionloopError

Controller = Callable[[Array], Complex]
"""C, from frequencies in Hz to error-to-command, complex; without the delay and the hold, which the plant has."""
RESONANCE = (-0.1, -0.05, 0.0, 0.05, 0.1)
"""Shares by which the resonance is off."""
GAIN = (0.65, 1.0, 1.35)
"""Factors on the loop gain: tau +-35 % from finger to finger, behind a lookup that does not know it."""
SPEED_MM_S = (20.0, 40.0, 80.0, 150.0)
"""Speeds at which the contact's pole is taken."""
NEAR = 1e-3
"""Distance from -1 that straight lines between points of the grid do not tell from the other side (assumed)."""


@dataclass(frozen=True, eq=False)
class PlantGrid:
    """The responses of all plants of `robustness`, kept to judge many controllers."""

    axes: Mapping[str, Sequence[Any]]
    plants: Mapping[tuple[int, int, int], tuple[Array, Complex]]
    """Frequencies in Hz up to half the rate, and f_m from u there, by place in resonance, contact and speed."""
    period_s: float

    @classmethod
    def of(
        cls,
        system: System,
        resonance: Sequence[float] = RESONANCE,
        gain: Sequence[float] = GAIN,
        contact: Sequence[str] = ("dahl", "slider"),
        speed_mm_s: Sequence[float] = SPEED_MM_S,
        force_n: float | None = None,
    ) -> PlantGrid:
        """Return the plants for the arguments of `robustness`."""
        check_system(system)
        axes = {"resonance": resonance, "gain": gain, "contact": contact, "speed_mm_s": speed_mm_s}
        for name, values in axes.items():
            if not len(values):
                raise FrictionloopError(f"{name} = []: at least one value is needed")
        if not all(math.isfinite(g) and g > 0 for g in gain):
            raise FrictionloopError(f"gain = {list(gain)}: must be finite and above 0")
        plants = {place: _on_grid(loop) for place, loop in _plants(system, resonance, contact, speed_mm_s, force_n)}
        return cls(axes, plants, 1.0 / system.controller.rate_hz)

    def judged(self, controller: Controller, noise: NoiseModel | None = None, integrators: int = 1) -> xr.Dataset:
        """Return the table of `robustness` for a controller."""
        names = ("sensitivity_peak", "stable", "residual_rms_n")[: 3 if noise else 2]
        table = {name: np.full([len(values) for values in self.axes.values()], np.nan) for name in names}
        for (i, k, m), (frequency, response) in self.plants.items():
            G = controller(frequency) * response
            for j, factor in enumerate(self.axes["gain"]):
                row = _scores(factor * G, frequency, self.period_s, integrators, noise)
                for name, value in zip(names, row, strict=False):
                    table[name][i, j, k, m] = value
        return _dataset(table, self.axes)


def _plants(
    system: System, resonance: Sequence[float], contact: Sequence[str], speeds: Sequence[float], force_n: float | None
) -> Iterator[tuple[tuple[int, int, int], LinearLoop]]:
    for (i, off), (k, law), (m, speed) in product(enumerate(resonance), enumerate(contact), enumerate(speeds)):
        yield (i, k, m), linearise(system.evolve(_changes(system, off, law, speed)), force_n=force_n)


def _changes(system: System, off: float, law: str, speed: float) -> Mapping[str, Any]:
    changes: dict[str, Any] = {}
    if isinstance(system.sensor, LowpassSensor):
        if off:
            raise FrictionloopError(f"resonance = {off:g}: sensor.kind = 'lowpass' has none; accepted is 0")
    else:
        if not off > -1:
            raise FrictionloopError(f"resonance = {off:g}: must be above -1")
        changes["sensor.resonance_hz"] = system.sensor.resonance_hz * (1 + off)
    if isinstance(system.finger, Skin):
        changes["finger.contact"] = law
    if isinstance(system.motion, Strokes):
        changes["motion.speed_mm_s"] = speed
        changes["motion.reversal_s"] = min(system.motion.reversal_s, system.motion.stroke_mm / speed)
    return changes


def _on_grid(loop: LinearLoop) -> tuple[Array, Complex]:
    """Return a dense grid with the Nyquist frequency, and f_m from u there."""
    frequency = np.append(loop.search_grid(1e-3), loop.nyquist_hz)
    frequency = frequency[frequency >= 1e-3]
    return frequency, loop.plant.response(frequency)[:, 1, 0]


def _scores(
    G: Complex, frequency: Array, period_s: float, integrators: int, noise: NoiseModel | None
) -> tuple[float, bool, float]:
    stable = poles_outside(G, frequency, period_s, integrators) == 0 and _distance(G) > NEAR
    sensitivity = np.abs(1 / (1 + G))
    residual = residual_rms_n(sensitivity, frequency, noise) if noise and stable else math.nan
    return (1 / _distance(G) if stable else math.inf), stable, residual


def _distance(G: Complex) -> float:
    """Return the smallest distance of -1 from the straight lines between the points of G."""
    here, way = 1 + G[:-1], np.diff(G)
    share = np.clip(-(here * way.conj()).real / np.maximum(np.abs(way) ** 2, 1e-300), 0.0, 1.0)
    return float(np.abs(here + share * way).min())


def residual_rms_n(sensitivity: Array, frequency_hz: Array, noise: NoiseModel) -> float:
    """Return the rms that |S| leaves of a disturbance from 1 to 500 Hz, N; ``frequency_hz`` rising, dense."""
    band = (frequency_hz >= 1.0) & (frequency_hz <= 500.0)
    inside = frequency_hz[band]
    return float(np.sqrt(np.trapezoid(noise.density(inside) * sensitivity[band] ** 2, inside)))


def _dataset(table: Mapping[str, Array], axes: Mapping[str, Sequence[Any]]) -> xr.Dataset:
    dims = tuple(axes)
    units = {"sensitivity_peak": "", "stable": "", "residual_rms_n": "N"}
    found = xr.Dataset(
        {name: (dims, values, {"units": units[name]}) for name, values in table.items()},
        {name: (name, np.asarray(values)) for name, values in axes.items()},
    )
    found["stable"] = found["stable"].astype(bool)
    return found
