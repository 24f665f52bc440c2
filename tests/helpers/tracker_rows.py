"""What a row of the tracker's schedule leaves of the bench's disturbance, and its Ms, predicted for small signals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.signal import ss2tf
from tracker_loop import Plant, Row, answer

from frictionloop.analysis.state_space import Array
from frictionloop.control.tracker_gains import sensor_matrices
from frictionloop.parameters import Model, System

FORCE_N, ROUGHNESS, TREMOR_N, SMOOTHEST = 0.6, 0.05, 0.03, 0.01
"""What is rejected: the bench's roughness at 0.6 N and a third of its tremor, which load feed-forward leaves (assumed);
5 % and 30 mN of a bench that tells neither. Without any roughness no gain would pay: 1 % at the least."""
SPEEDS_M_S = {
    0.07: 0.015, 0.125: 0.02, 0.25: 0.045, 0.5: 0.05, 0.75: 0.05, 1.0: 0.02, 1.25: 0.08,
    1.5: 0.1, 1.75: 0.08, 1.875: 0.08,
}  # fmt: skip
"""Speed whose disturbance a row is tuned for: near that at which its share occurs at 0.6 N under the bench's Dahl
contact, at 5 kHz; 0.75 to 1.25 are a slider's (chosen)."""
ALSO = {0.5: (1.0,), 0.75: (1.0,), 1.5: (1.0,)}
"""True shares that a row has to hold for besides its own: at 80 mm/s a slider is taken for a contact of 30 to 50 um/N,
a share of 0.4, and has more on its way from there (measured on fingers(240, 3))."""
TIGHTER = {0.125: 0.06}
"""Share by which Ms - 1 of a row stays below its limits: between it and the next row a loop has more than at either."""


def believed_share(place: float) -> float:
    """Return the share that a place stands for (`limit_observer.place_of`)."""
    return min(place, 1.0) if place <= 1.25 else 2.0 - place


def true_shares(place: float) -> tuple[float, ...]:
    """Return the shares 1 - e^(-dt/T), T/dt = 1/place - 1, of the plants that a row has to hold for."""
    share = believed_share(place)
    own = 1.0 if share >= 1.0 else -math.expm1(-share / (1.0 - share))
    return (own, *ALSO.get(place, ()))


class Prediction:
    """The plants and the disturbance at one of ``PLACES``."""

    def __init__(
        self, system: System, true: Model, believed: Model, place: float, limits: Mapping[float, float]
    ) -> None:
        self.dt, self.share, self.believed = 1.0 / system.controller.rate_hz, believed_share(place), believed
        tighter = 1.0 - TIGHTER.get(place, 0.0)
        self.limits = {off: 1.0 + tighter * (limit - 1.0) for off, limit in limits.items()}
        self.near = min((size for size in limits if size), default=0.0)
        """Error of the resonance up to which the residual counts."""
        offs = [off for size in limits for off in sorted({-size, size})]
        sensors = {off: true.model_copy(update={"resonance_hz": true.resonance_hz * (1.0 + off)}) for off in offs}
        nyquist, f0 = 0.5 / self.dt, true.resonance_hz
        self.f = np.unique(
            np.concatenate(
                [
                    np.geomspace(1.0, 0.55 * f0, 40),
                    np.linspace(0.55 * f0, 1.8 * f0, 110),
                    np.geomspace(1.8 * f0, nyquist, 80),
                ]
            )
        )[:-1]
        self.z = np.exp(2j * np.pi * self.f * self.dt)
        sensor: Any = system.sensor
        rough = max(getattr(system.friction, "roughness_rms", ROUGHNESS), SMOOTHEST)
        tremor_n = getattr(system.motion, "tremor_n", TREMOR_N) / 3.0
        white = sensor.noise_density_n_rthz**2 / (1.0 + (self.f / sensor.cutoff_hz) ** 2)
        self.noise = white + sensor.step_n**2 / 12.0 / nyquist
        self.plants = [
            (
                {off: Plant(each, goes) for off, each in sensors.items()},
                _disturbance(self.f, (rough, tremor_n), SPEEDS_M_S[place], behind, self.dt),
            )
            for goes, behind in zip(true_shares(place), (self.share, *ALSO.get(place, ())), strict=True)
        ]
        """By contact: the plants by how far the resonance is off, and the disturbance behind the contact."""

    def residual(self, row: Row) -> tuple[float, dict[float, float]]:
        """Return residual (N) and worst Ms by resonance."""
        peaks: dict[float, float] = {}
        total = 0.0
        for plants, disturbance in self.plants:
            left = {}
            for off, plant in plants.items():
                found = answer(row, self.believed, self.share, plant, self.z, self.dt)
                stable = found.radius < 1.0
                peak = float(np.abs(found.sensitivity).max()) if stable else 10.0 + 50.0 * (found.radius - 1.0)
                peaks[off] = max(peaks.get(off, 0.0), peak)
                from_noise = self.power(found.friction_from_noise, self.noise)
                left[off] = math.sqrt(self.power(found.sensitivity, disturbance) + from_noise)
            near = [value for off, value in left.items() if abs(off) <= self.near]
            total += 0.5 * left[0.0] + 0.5 * float(np.mean(near))
        return total / len(self.plants), peaks

    def power(self, response: Any, density: Array) -> float:
        """Return the variance behind a response."""
        return float(np.trapezoid(np.abs(response) ** 2 * density, self.f))


def _disturbance(frequency_hz: Array, sources: tuple[float, float], speed_m_s: float, share: float, dt: float) -> Array:
    """Return the density of friction's fluctuation without control in N^2/Hz, behind the contact of this share.

    Sources are the roughness, relative, and what is left of the tremor, N.
    """
    lowest = speed_m_s / 0.1
    highest = 1024.0 * lowest
    rough = (FORCE_N * sources[0]) ** 2 / (frequency_hz * math.log(1024.0)) / (1.0 + (frequency_hz / highest) ** 8)
    tremor = sources[1] ** 2 / (2.0 * math.pi) / (1.0 + ((frequency_hz - 10.0) / 2.0) ** 2)
    total = np.where(frequency_hz >= lowest, rough, 0.0) + tremor
    if share < 1.0:
        total = total / (1.0 + (2.0 * math.pi * frequency_hz * dt * (1.0 / share - 1.0)) ** 2)
    return np.asarray(total)


def plant_paths(plant: Plant, dt: float) -> tuple[Array, Array, Array]:
    """Return numerators to reading and friction from the limit that is commanded, and poles: coefficients of z^-k."""
    a, b0, b1 = sensor_matrices(plant.sensor, dt)
    now, ahead, friction = np.eye(6)[:3]
    left = plant.gain * (ahead if plant.share >= 1.0 else 0.5 * (now + ahead))
    matrix = np.zeros((6, 6))
    matrix[0], matrix[2] = ahead, friction + plant.share * (left - friction)
    matrix[3:, 3:] = a
    matrix[3:] += np.outer(b0, friction) + np.outer(b1, matrix[2])
    numerators, poles = ss2tf(matrix, np.eye(6)[:, [1]], np.eye(6)[[5, 2]], np.zeros((2, 1)))
    return numerators[0], numerators[1], poles
