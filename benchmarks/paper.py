"""The loop of the paper's Section 2 in plain numbers, for every contender that is not frictionloop itself."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from math import exp, log, pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Paper:
    """Printed values (peak-to-peak reading); the order of the fields is that of `System` in reference.c."""

    f0: float = 0.8
    tau: float = 0.38
    a_max: float = 2.5
    plate_hz: float = 100.0
    sensor_hz: float = 1000.0
    noise_rms: float = 1e-5
    rate_hz: float = 5000.0
    setpoint_offset: float = 0.6
    setpoint_amplitude: float = 0.6
    start_hz: float = 1.0
    stop_hz: float = 100.0
    sweep_s: float = 10.0
    disturbance_offset: float = 0.4
    disturbance_amplitude: float = 0.4
    disturbance_hz: float = 1.0

    @property
    def period_s(self) -> float:
        return 1.0 / self.rate_hz

    @property
    def low(self) -> float:
        """Lowest force without disturbance, g(a_max)."""
        return self.f0 * exp(-self.tau * self.a_max**2)

    def numbers(self) -> tuple[float, ...]:
        return astuple(self)

    def set_point(self, t: Any, xp: Any = np) -> Any:
        """Logarithmic sweep; `xp` is numpy or jax.numpy."""
        octaves = log(self.stop_hz / self.start_hz)
        phase = 2 * pi * self.start_hz * self.sweep_s / octaves * xp.expm1(octaves * t / self.sweep_s)
        return self.setpoint_offset + self.setpoint_amplitude * xp.sin(phase)

    def disturbance(self, t: Any, xp: Any = np) -> Any:
        return self.disturbance_offset + self.disturbance_amplitude * xp.sin(2 * pi * self.disturbance_hz * t)


@dataclass(frozen=True)
class Period:
    """What one control period needs: plate decay and sensor weight at the nodes of a rule."""

    at: Array
    plate: Array
    weight: Array
    sensor: float


def lobatto(p: Paper) -> Period:
    """Six-node Gauss-Lobatto rule for the sensor's convolution over a period (Abramowitz and Stegun, table 25.6)."""
    outer, inner = sqrt((1 + 2 / sqrt(7)) / 3), sqrt((1 - 2 / sqrt(7)) / 3)
    nodes = np.array([-1, -outer, -inner, inner, outer, 1])
    light, heavy = (14 - sqrt(7)) / 30, (14 + sqrt(7)) / 30
    weights = np.array([1 / 15, light, heavy, heavy, light, 1 / 15]) / 2
    at = (1 + nodes) / 2 * p.period_s
    w = 2 * pi * p.sensor_hz
    kernel = w * np.exp(-w * (p.period_s - at)) * p.period_s
    return Period(at, np.exp(-2 * pi * p.plate_hz * at), weights * kernel, exp(-w * p.period_s))


def ramps(p: Paper, substeps: int = 10) -> Period:
    """The rule people write before looking for a better one: equal substeps, force linear in each."""
    at = np.linspace(0.0, p.period_s, substeps + 1)
    w, h = 2 * pi * p.sensor_hz, p.period_s / substeps
    decay = exp(-w * h)
    early, late = (1 - decay) / (w * h) - decay, 1 - (1 - decay) / (w * h)  # exact for a ramp over one substep
    weight = np.zeros(substeps + 1)
    for j in range(substeps):
        weight[[j, j + 1]] += np.array([early, late]) * exp(-w * (p.period_s - at[j + 1]))
    return Period(at, np.exp(-2 * pi * p.plate_hz * at), weight, exp(-w * p.period_s))


def signals(p: Paper, periods: int, noise: Any, xp: Any = np) -> tuple[Any, Any, Any]:
    """Set-point, disturbance, and what disturbance and noise add to f_m over each period."""
    rule, t = lobatto(p), xp.arange(periods) / p.rate_hz
    turn = 2 * pi * p.disturbance_hz * rule.at  # sin(a + b) expanded: two sines per period instead of six
    d, quarter = p.disturbance(t, xp), p.disturbance(t + 0.25 / p.disturbance_hz, xp)
    sine, cosine = d - p.disturbance_offset, quarter - p.disturbance_offset
    smoothed = sine * float(rule.weight @ np.cos(turn)) + cosine * float(rule.weight @ np.sin(turn))
    added = p.disturbance_offset * float(rule.weight.sum()) + smoothed + (1 - rule.sensor) * noise
    return p.set_point(t, xp), d, added


def draw(p: Paper, periods: int, seed: int = 0) -> Array:
    """Sensor noise, one number per control period."""
    return np.random.default_rng(seed).normal(0.0, p.noise_rms, periods) if p.noise_rms else np.zeros(periods)


def r2_identity(f_a: Array, f_r: Array) -> float:
    return float(1 - np.sum((f_a - f_r) ** 2) / np.sum((f_r - f_r.mean()) ** 2))


def gain_grid(side: int = 32) -> tuple[Array, Array]:
    """Axes of the grid: Kp 1..100, Ki 0.1..100, logarithmic."""
    return np.logspace(0, 2, side), np.logspace(-1, 2, side)
