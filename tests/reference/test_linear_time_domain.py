"""The state space against a step-by-step integration of the differential equations, written out here."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from linear_runs import run_linear

from frictionloop.analysis import linearise
from frictionloop.parameters import System, paper

STEPS = 40
"""Runge-Kutta steps per stretch: at ws h = 2 pi 1000 * 2e-4 / 40 = 0.03 the error per period is below 1e-9."""


Slope = Callable[[float, np.ndarray], np.ndarray]


def runge_kutta(slope: Slope, t: float, y: np.ndarray, span: float) -> np.ndarray:
    h = span / STEPS
    for i in range(STEPS):
        at = t + i * h
        k1 = slope(at, y)
        k2 = slope(at + h / 2, y + h / 2 * k1)
        k3 = slope(at + h / 2, y + h / 2 * k2)
        k4 = slope(at + h, y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return y


def integrate(system: System, f_r: np.ndarray, d: np.ndarray, n: np.ndarray, gain: float = 1.0) -> np.ndarray:
    """Return [f_a, f_m, u] at the samples: da/dt = wc (gain u - a), df_m/dt = ws (a + d(t) + n - f_m)."""
    c = system.controller
    w_plate, w_sensor = 2 * np.pi * system.plate.cutoff_hz, 2 * np.pi * system.sensor.cutoff_hz
    ts = 1 / c.rate_hz
    y, integral = np.zeros(2), 0.0
    starts, commands, rows = [-np.inf], [0.0], []
    for k in range(len(f_r)):
        t = k * ts
        error = f_r[k] - y[1]
        u = c.kp * error + integral
        integral += c.ki * ts * error
        rows.append((y[0] + d[k], y[1], u))
        starts.append(t + c.delay_s)
        commands.append(u)
        rise = (d[min(k + 1, len(d) - 1)] - d[k]) / ts
        for low, high in pairwise([t, *(s for s in starts if t + 1e-12 < s < t + ts - 1e-12), t + ts]):
            held = commands[np.searchsorted(starts, (low + high) / 2) - 1]
            into = w_plate * gain * held, w_sensor * (d[k] - rise * t + n[k]), w_sensor * rise

            def slope(at: float, y: np.ndarray, into: tuple[float, float, float] = into) -> np.ndarray:
                drive, force, ramp = into
                return np.array([drive - w_plate * y[0], force + ramp * at + w_sensor * (y[0] - y[1])])

            y = runge_kutta(slope, low, y, high - low)
    return np.array(rows)


@pytest.mark.parametrize("delay_s", [0.0, 7e-5, 2e-4, 4.6e-4])
@pytest.mark.parametrize("ki", [0.0, 300.0])
def test_closed_loop_from_rest(delay_s: float, ki: float) -> None:
    rng = np.random.default_rng(3)
    f_r, d, n = rng.normal(size=(3, 60))
    d[0] = 0.0  # from rest: the sensor has seen no disturbance before t = 0
    system = paper().evolve({"controller.kp": 3.0, "controller.ki": ki, "controller.delay_s": delay_s})
    ours = run_linear(linearise(system).state_space(), np.column_stack([f_r, d, n]))
    np.testing.assert_allclose(ours, integrate(system, f_r, d, n), atol=1e-7)


def test_a_wrong_model_changes_the_gain() -> None:
    system = paper().evolve({"friction.susceptibility_per_um2": 0.6, "controller.kp": 3.0})
    loop = linearise(system, amplitude_um=0.5)
    gain = (0.6 * np.exp(-0.6 * 0.25)) / (0.38 * np.exp(-0.38 * 0.25))
    rng = np.random.default_rng(4)
    f_r, d, n = rng.normal(size=(3, 30))
    d[0] = 0.0
    ours = run_linear(loop.state_space(), np.column_stack([f_r, d, n]))
    np.testing.assert_allclose(ours, integrate(system, f_r, d, n, gain), atol=1e-7)


@pytest.mark.parametrize("delay_s", [0.0, 7e-5, 2e-4, 4.6e-4, 1.01e-2])
def test_transfer_functions_are_those_of_the_state_space(delay_s: float) -> None:
    """Two routes: the algebra of equation (2) with z^-m for the delay, and one state per delayed command."""
    loop = linearise(paper().evolve({"controller.kp": 2.0, "controller.ki": 50.0, "controller.delay_s": delay_s}))
    frequency = np.geomspace(0.1, 2500, 60)
    closed, r = loop.state_space().response(frequency), loop.responses(frequency)
    for k, name in enumerate(("f_a_from_f_r", "f_a_from_d", "f_a_from_n")):
        np.testing.assert_allclose(closed[:, 0, k], r[name], rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(closed[:, 2, 2], r["u_from_n"], rtol=1e-8)


def test_a_whole_delay_is_continuous_with_its_neighbours() -> None:
    frequency = np.geomspace(1, 2500, 20)

    def G(delay_s: float) -> np.ndarray:
        return linearise(paper().evolve({"controller.delay_s": delay_s})).responses(frequency)["G"]

    for near in (2e-4 * (1 - 1e-8), 2e-4 * (1 + 1e-8), 0.0002 + 1e-17):
        np.testing.assert_allclose(G(near), G(2e-4), rtol=1e-6)
