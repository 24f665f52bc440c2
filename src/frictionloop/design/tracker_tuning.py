"""The tracker's schedule for a bench: at each share the Kalman gains, lead and trust that leave the least residual.

A Kalman filter needs ratios of noise. They are not known but chosen, together with lead and trust: the ones with the
least predicted residual on the identified disturbance among those that keep Ms below a limit, also with the resonance
off, and the noise of the command within bounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.linalg import solve_discrete_are
from scipy.optimize import minimize
from threadpoolctl import threadpool_limits

from frictionloop.design.state_space import Array
from frictionloop.design.tracker_loop import Plant, Row, answer, observer_matrix
from frictionloop.parameters import Model, SuspendedSensor, System
from frictionloop.parameters.tracking import SHARES
from frictionloop.quantities import FrictionloopError

LIMITS: Mapping[float, float] = {0.0: 1.7, 0.05: 2.0, 0.1: 2.6}
"""Largest Ms by how far the resonance is off, relative, to either side."""
BELIEVED_RESONANCE, BELIEVED_Q = 0.91, 6.0
"""Resonance over the true one, and its Q: low and broad, as too high is fatal (of 18 pairs tried, from 0.86 to 0.97 and
1.5 to 9, among the best within 2 %; at 0.92 Ms at the limits of the resonance is higher)."""
LOUDEST_FORCE_N, LOUDEST_COMMAND_N = 1.2e-3, 25e-3
"""Largest rms of friction and of the commanded limit that sensor noise may cause (chosen: louder, the tip sticks)."""
LARGEST_FRICTION_GAIN = 40.0
"""Largest gain on the friction, N per N of innovation (chosen: louder, the believed friction falls as if it rang)."""
LOW = np.log([1e-4, 1e-5, 1e-6, 1e-7, 5e-5, 0.5])
HIGH = np.log([1e-2, 1e-2, 1e-2, 1e-2, 5e-3, 1.1])
"""Bounds of what is searched: noise of the limit per period (N), of a reading (N), of friction (N), of the springs (N),
time constant to which the contact is sped up (s), trust."""
STARTS, STEPS = 7, 170
FORCE_N, ROUGHNESS, TREMOR_LEFT_N = 0.6, 0.05, 0.01
"""What is rejected: roughness of 5 % at 0.6 N, and what load feed-forward leaves of the tremor (assumed)."""
SPEEDS_M_S = {0.07: 0.015, 0.125: 0.02, 0.25: 0.045, 0.5: 0.1, 1.0: 0.03}
"""Speed at which a share occurs at 0.6 N under the bench's Dahl contact; 1 is a slider's (chosen)."""
ALSO = {0.5: (1.0,)}
"""True shares that a row has to hold for besides its own: a slider is taken for a contact of 6 to 10 um/N, as it lags
while its skin is loaded, so at 20 mm/s a share of 0.5 is believed of it (measured on fingers(60, 3))."""


@dataclass(frozen=True, eq=False)
class TrackerTuning:
    """A schedule and what is predicted of it, row by row."""

    rows: tuple[Row, ...]
    true: Model
    """What the tracker has to be told of the sensor."""
    residual_n: tuple[float, ...]
    peaks: tuple[dict[float, float], ...] = field(repr=False)
    """Ms by how far the resonance is off."""

    @property
    def overrides(self) -> dict[str, Any]:
        """The tracker as overrides for ``System.evolve``."""
        return {
            "controller.kind": "tracker",
            "controller.schedule": tuple(tuple(float(f"{v:.4g}") for v in row) for row in self.rows),
            "controller.resonance_share": BELIEVED_RESONANCE,
            "controller.broadened_q": BELIEVED_Q,
            "controller.model.resonance_hz": self.true.resonance_hz,
            "controller.model.resonance_q": self.true.resonance_q,
            "controller.model.sensor_hz": self.true.sensor_hz,
        }


def tune_tracker(
    system: System,
    limits: Mapping[float, float] = LIMITS,
    seed: int = 0,
    *,
    progress: Callable[[], None] | None = None,
) -> TrackerTuning:
    """Return the schedule with the least predicted residual whose Ms stays below limits.

    The tracker believes that friction goes the share 1/(1 + T/dt) of the way to its limit in a period; the plants that
    are tuned go as a sampled Dahl contact under a held speed does, 1 - e^(-dt/T), which is more (`true_shares`).

    Parameters
    ----------
    system
        The bench: its sensor, rate and delay (one period, as the schedule is made for).
    limits
        Largest Ms by how far the true resonance is off to either side, relative; 0 must be among them.
    seed
        Of the starts of the search, which is local.
    progress
        Called after each row of the schedule.

    Raises
    ------
    FrictionloopError
        For a sensor without suspension, limits without 0 or not above 1, or a share at which no gains keep to them.
    """
    if not isinstance(system.sensor, SuspendedSensor):
        raise FrictionloopError(f'sensor.kind = "{system.sensor.kind}": a tracker is tuned for a "suspended" one')
    if 0.0 not in limits or not all(limit > 1.0 for limit in limits.values()):
        raise FrictionloopError(f"limits = {dict(limits)}: must have 0 and largest Ms above 1, such as {dict(LIMITS)}")
    sensor = system.sensor
    true = system.controller.model.model_copy(
        update={"resonance_hz": sensor.resonance_hz, "resonance_q": sensor.q, "sensor_hz": sensor.cutoff_hz}
    )
    believed = true.model_copy(
        update={"resonance_hz": BELIEVED_RESONANCE * sensor.resonance_hz, "resonance_q": BELIEVED_Q}
    )
    found = []
    with threadpool_limits(limits=1, user_api="blas"):  # matrices of 12: more threads only wait for each other
        for share in SHARES:
            found.append(_Search(system, true, believed, share, limits).best(seed))
            if progress is not None:
                progress()
    return TrackerTuning(
        tuple(row for row, _, _ in found), true, tuple(j for _, j, _ in found), tuple(p for _, _, p in found)
    )


def true_shares(share: float) -> tuple[float, ...]:
    """Return the shares 1 - e^(-dt/T), T/dt = 1/share - 1, of the plants that a row has to hold for."""
    own = 1.0 if share >= 1.0 else -math.expm1(-share / (1.0 - share))
    return (own, *ALSO.get(share, ()))


class _Search:
    """The search at one share."""

    def __init__(
        self, system: System, true: Model, believed: Model, share: float, limits: Mapping[float, float]
    ) -> None:
        self.dt, self.share, self.believed, self.limits = 1.0 / system.controller.rate_hz, share, believed, limits
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
        white = sensor.noise_density_n_rthz**2 / (1.0 + (self.f / sensor.cutoff_hz) ** 2)
        self.noise = white + sensor.step_n**2 / 12.0 / nyquist
        self.plants = [
            ({off: Plant(each, goes) for off, each in sensors.items()}, _disturbance(self.f, behind, self.dt))
            for goes, behind in zip(true_shares(share), (share, *ALSO.get(share, ())), strict=True)
        ]
        """By contact: the plants by how far the resonance is off, and the disturbance behind the contact."""

    def row(self, x: Array) -> Row:
        """Return the row of a point of the search."""
        limit, reading, friction, springs, time_s, trust = np.exp(x)
        matrix = observer_matrix(self.believed, self.share, self.dt)
        out = np.eye(5)[:, 4:]
        driven = np.diag([limit**2, friction**2, springs**2, springs**2, 0.0]) + 1e-14 * np.eye(5)
        spread = solve_discrete_are(matrix.T, out, driven, [[reading**2]])
        gains = (spread @ out / (out.T @ spread @ out + reading**2)).ravel()
        lead = min(self.share / -math.expm1(-self.dt / time_s), 1.0)
        kd, kf, k1, k2, k3 = (float(gain) for gain in gains)
        return Row(kd, kf, k1, k2, k3, lead, float(trust))

    def residual(self, row: Row) -> tuple[float, dict[float, float], float, float]:
        """Return residual (N), worst Ms by resonance, and the rms of friction and command from noise (N)."""
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
                left[off] = math.sqrt(self.power(found.sensitivity, disturbance) + from_noise)
                if off == 0.0:
                    loud = max(loud, math.sqrt(from_noise))
                    louder = max(louder, math.sqrt(self.power(found.limit_from_noise, self.noise)))
            near = [value for off, value in left.items() if abs(off) <= 0.05]
            total += 0.5 * left[0.0] + 0.5 * float(np.mean(near))
        return total / len(self.plants), peaks, loud, louder

    def power(self, response: Any, density: Array) -> float:
        """Return the variance behind a response."""
        return float(np.trapezoid(np.abs(response) ** 2 * density, self.f))

    def cost(self, x: Array) -> float:
        """Return the residual in mN, with a price on each bound that is not kept."""
        if np.any(x < LOW) or np.any(x > HIGH):
            return 1e4
        try:
            row = self.row(x)
            left, peaks, loud, louder = self.residual(row)
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


def _disturbance(frequency_hz: Array, share: float, dt: float) -> Array:
    """Return the density of friction's fluctuation without control in N^2/Hz, behind the contact of this share."""
    lowest = SPEEDS_M_S[share] / 0.1
    highest = 1024.0 * lowest
    rough = (FORCE_N * ROUGHNESS) ** 2 / (frequency_hz * math.log(1024.0)) / (1.0 + (frequency_hz / highest) ** 8)
    tremor = TREMOR_LEFT_N**2 / (2.0 * math.pi) / (1.0 + ((frequency_hz - 10.0) / 2.0) ** 2)
    total = np.where(frequency_hz >= lowest, rough, 0.0) + tremor
    if share < 1.0:
        total = total / (1.0 + (2.0 * math.pi * frequency_hz * dt * (1.0 / share - 1.0)) ** 2)
    return np.asarray(total)
