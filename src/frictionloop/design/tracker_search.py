"""A row of the tracker's schedule: Kalman gains, lead and trust for one share, by the residual that is predicted.

A Kalman filter needs ratios of noise. They are not known but chosen, together with lead and trust: the ones with the
least predicted residual of the bench's disturbance among those that keep Ms below a limit, also with the resonance
off, and the noise of the command within bounds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.optimize import minimize

from frictionloop.analysis.state_space import Array
from frictionloop.control.observer_gains import kalman_gains
from frictionloop.design.tracker_loop import Plant, Row, answer, observer_matrix
from frictionloop.parameters import Model, System
from frictionloop.perception.weighting import felt_power
from frictionloop.quantities import FrictionloopError

LOUDEST_FORCE_N, LOUDEST_COMMAND_N = 1.2e-3, 25e-3
"""Largest rms of friction and of the commanded limit that sensor noise may cause (chosen: louder, the tip sticks)."""
LARGEST_FRICTION_GAIN = 33.0
"""Largest gain on the friction, N per N of innovation (chosen on fingers(120, 3): above it the residual grows)."""
LOW = np.log([1e-4, 1e-5, 1e-6, 1e-7, 5e-5, 0.5])
HIGH = np.log([1e-2, 1e-2, 1e-2, 1e-2, 5e-3, 1.1])
"""Bounds of what is searched: noise of the limit per period (N), of a reading (N), of friction (N), of the springs (N),
time constant to which the contact is sped up (s), trust."""
STARTS, STEPS = 7, 170
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
TOUCH = {0.75: 0.2, 1.25: 0.2, 1.5: 2.0, 1.75: 0.5, 1.875: 0.5}
"""Weight of what is felt, at 100 Hz, beside 1 of all that is left of the disturbance: a stroke at 80 mm/s then feels
an eighth less on a slider for 1 % more of rms under Dahl. What is tuned for a quick slider with a weight of 1 or more
hardly acts at all. The other rows are for slow strokes, of which less is felt (chosen on fingers(120, 3))."""
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


class RowSearch:
    """The search at one of ``PLACES``."""

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
        felt = felt_power([*self.f, 100.0], system.controller.rate_hz)
        self.felt = 1.0 + TOUCH.get(place, 0.0) * felt[:-1] / felt[-1]
        """What the disturbance left is weighted by: the power of a force over that at the threshold of touch."""
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

    def row(self, x: Array) -> Row:
        """Return the row of a point of the search."""
        limit, reading, friction, springs, time_s, trust = np.exp(x)
        matrix = observer_matrix(self.believed, self.share, self.dt)
        driven = np.diag([limit**2, friction**2, springs**2, springs**2, 0.0]) + 1e-14 * np.eye(5)
        gains = kalman_gains(matrix, np.eye(1, 5, 4), driven, reading**2)
        lead = min(self.share / -math.expm1(-self.dt / time_s), 1.0)
        kd, kf, k1, k2, k3 = (float(gain) for gain in gains)
        return Row(kd, kf, k1, k2, k3, lead, float(trust))

    def residual(self, row: Row, weight: float | Array = 1.0) -> tuple[float, dict[float, float], float, float]:
        """Return residual (N), weighted, worst Ms by resonance, and rms of friction and command from noise (N)."""
        peaks: dict[float, float] = {}
        total, loud, louder = 0.0, 0.0, 0.0
        for plants, disturbance in self.plants:
            left = {}
            for off, plant in plants.items():
                found = answer(row, self.believed, self.share, plant, self.z, self.dt)
                stable = found.radius < 1.0
                peak = float(np.abs(found.sensitivity).max()) if stable else 10.0 + 50.0 * (found.radius - 1.0)
                peaks[off] = max(peaks.get(off, 0.0), peak)
                from_noise = self.power(found.friction_from_noise, self.noise)
                left[off] = math.sqrt(self.power(found.sensitivity, weight * disturbance) + from_noise)
                if off == 0.0:
                    loud = max(loud, math.sqrt(from_noise))
                    louder = max(louder, math.sqrt(self.power(found.limit_from_noise, self.noise)))
            near = [value for off, value in left.items() if abs(off) <= self.near]
            total += 0.5 * left[0.0] + 0.5 * float(np.mean(near))
        return total / len(self.plants), peaks, loud, louder

    def power(self, response: Any, density: Array) -> float:
        """Return the variance behind a response."""
        return float(np.trapezoid(np.abs(response) ** 2 * density, self.f))

    def cost(self, x: Array) -> float:
        """Return the residual in mN, as it is felt, with a price on each bound that is not kept."""
        if np.any(x < LOW) or np.any(x > HIGH):
            return 1e4
        try:
            row = self.row(x)
            if min(row) < 0.0:
                return 1e3
            left, peaks, loud, louder = self.residual(row, self.felt)
        except (np.linalg.LinAlgError, ValueError):
            return 1e3
        over = sum(max(peak / self.limits[abs(off)] - 1.0, 0.0) for off, peak in peaks.items())
        noisy = max(loud / LOUDEST_FORCE_N - 1.0, 0.0) + max(louder / LOUDEST_COMMAND_N - 1.0, 0.0)
        noisy += max(row.friction / LARGEST_FRICTION_GAIN - 1.0, 0.0)
        return 1e3 * left + 60.0 * over + 20.0 * noisy

    def best(self, seed: int) -> tuple[Row, float, dict[float, float]]:
        """Return the best row found, its residual in N and its peaks."""
        draws = np.random.default_rng(seed).uniform(LOW, HIGH, (8 * STARTS, LOW.size))
        starts = sorted(draws, key=self.cost)[:STARTS]
        ends = [_descend(self.cost, start) for start in starts]
        last = _descend(self.cost, min(ends, key=self.cost))
        row = self.row(last)
        if min(row) < 0.0:
            raise FrictionloopError(
                f"sensor.resonance_hz, believed {self.believed.resonance_hz:.4g} Hz: no gains of at least 0 are found "
                f"where friction goes {self.share:g} of its way in a period"
            )
        left, peaks, _, _ = self.residual(row)
        for off, peak in peaks.items():
            if peak > 1.02 * self.limits[abs(off)]:
                raise FrictionloopError(
                    f"limits: {self.limits[abs(off)]:g} with the resonance off by {abs(off):g} is not reached where "
                    f"friction goes {self.share:g} of its way in a period; {peak:.3g} is what the search finds"
                )
        return row, left, peaks


def _descend(cost: Any, start: Array) -> Array:
    found = minimize(cost, start, method="Nelder-Mead", options={"maxiter": STEPS, "xatol": 1e-3, "fatol": 1e-3})
    return np.asarray(found.x)


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
