"""The state space against a step-by-step integration of the differential equations, written out here."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

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


# The sampled loop against python-control, which shares no code with it but numpy's linear algebra.


control = pytest.importorskip("control")

TS = 1 / 5000
LOOPS = [
    {},
    {"controller.kp": 1.0},
    {"controller.kp": 40.0},
    {"controller.delay_s": 2e-4},
    {"controller.kp": 1.75, "controller.ki": 1100.0, "controller.delay_s": 2e-4},
    {"controller.kp": 3.0, "controller.ki": 0.0, "controller.delay_s": 6e-4, "sensor.cutoff_hz": 300.0},
]


def plate_and_sensor(system: System) -> tuple[Any, Any]:
    w_plate, w_sensor = 2 * np.pi * system.plate.cutoff_hz, 2 * np.pi * system.sensor.cutoff_hz
    return control.tf([w_plate], [1, w_plate]), control.tf([w_sensor], [1, w_sensor])


def pi_z(system: System) -> Any:
    c = system.controller
    if c.ki == 0:
        return control.tf([c.kp], [1], TS)
    return control.tf([c.kp, c.ki * TS - c.kp], [1, -1], TS)


def loop_z(system: System) -> Any:
    """C(z), P S(z) with a zero-order hold, and whole periods of delay."""
    plate, sensor = plate_and_sensor(system)
    periods = round(system.controller.delay_s / TS)
    series = control.sample_system(plate * sensor, TS, "zoh") * control.tf([1], [1, *np.zeros(periods)], TS)
    return pi_z(system) * series


@pytest.mark.parametrize("changes", LOOPS)
def test_loop_gain_and_sensitivities(changes: dict[str, float]) -> None:
    system = paper().evolve(changes)
    frequency = np.geomspace(0.1, 2499, 200)
    ours = linearise(system).frequency_response(frequency)
    G = loop_z(system)
    z = np.exp(2j * np.pi * frequency * TS)
    np.testing.assert_allclose(ours.G, G(z), rtol=1e-8)
    np.testing.assert_allclose(ours.S, control.feedback(1, G)(z), rtol=1e-7, atol=1e-10)
    np.testing.assert_allclose(ours.T, control.feedback(G, 1)(z), rtol=1e-7, atol=1e-10)


@pytest.mark.parametrize("changes", LOOPS)
def test_margins(changes: dict[str, float]) -> None:
    system = paper().evolve(changes)
    ours = linearise(system).margins()
    theirs = control.margin(loop_z(system))
    gain_margin, phase_margin, phase_crossover, crossover = theirs
    assert ours.gain_margin == pytest.approx(gain_margin, rel=1e-6)
    assert ours.phase_margin_deg == pytest.approx(phase_margin, rel=1e-6)
    assert ours.phase_crossover_hz == pytest.approx(phase_crossover / (2 * np.pi), rel=1e-6)
    assert ours.crossover_hz == pytest.approx(crossover / (2 * np.pi), rel=1e-6)
    distance = control.stability_margins(loop_z(system))[2]
    assert ours.modulus_margin == pytest.approx(distance, rel=1e-3)  # theirs is the best of a frequency grid


@pytest.mark.parametrize("changes", LOOPS)
def test_closed_loop_poles(changes: dict[str, float]) -> None:
    system = paper().evolve(changes)
    theirs = np.sort_complex(control.feedback(loop_z(system), 1).poles())
    ours = np.sort_complex(linearise(system).poles())
    # Poles of m-fold delay lie close together near 0; as polynomial roots theirs are good to eps^(1/(m+1)).
    np.testing.assert_allclose(ours, theirs, atol=1e-6)


@pytest.mark.parametrize("tenths", [0, 1, 5, 9, 13, 27])
def test_fractional_delay_by_lifting(tenths: int) -> None:
    """A delay of k tenths of a period is whole at ten times the rate: step the fast system ten times a period."""
    plate, sensor = plate_and_sensor(paper())
    w_plate, w_sensor = 2 * np.pi * 100, 2 * np.pi * 1000
    matrix, drive = np.array([[-w_plate, 0], [w_sensor, -w_sensor]]), np.array([[w_plate], [0]])
    both = control.ss(matrix, drive, np.eye(2), np.zeros((2, 1)))
    np.testing.assert_allclose(both(1j)[1], (plate * sensor)(1j), rtol=1e-12)
    fast = control.sample_system(both, TS / 10, "zoh")
    commands = np.random.default_rng(1).normal(size=60)
    held = np.concatenate([np.zeros(tenths), np.repeat(commands, 10)])
    state, expected = np.zeros(2), []
    for k, u in enumerate(held[: 10 * commands.size]):
        if k % 10 == 0:
            expected.append(state)
        state = fast.A @ state + fast.B[:, 0] * u
    plant = linearise(paper().evolve({"controller.delay_s": tenths * TS / 10})).plant.state_space()
    ours = run_linear(plant, np.column_stack([commands, np.zeros((60, 2))]))
    np.testing.assert_allclose(ours, expected, atol=1e-12)


def test_disturbance_is_linear_between_samples() -> None:
    """python-control's first-order hold, where u rises linearly to the next sample."""
    _, sensor = plate_and_sensor(paper())
    z = np.exp(2j * np.pi * np.geomspace(1, 2499, 50) * TS)
    ours = linearise(paper()).plant.response(np.geomspace(1, 2499, 50))
    np.testing.assert_allclose(ours[:, 1, 1], control.sample_system(sensor, TS, "foh")(z), rtol=1e-10)
    np.testing.assert_allclose(ours[:, 1, 2], control.sample_system(sensor, TS, "zoh")(z), rtol=1e-10)
    np.testing.assert_allclose(ours[:, 0, 1], 1, atol=1e-14)
    np.testing.assert_allclose(ours[:, 0, 2], 0, atol=1e-14)


def as_control(space) -> control.StateSpace:
    """Return a state space as python-control has it."""
    return control.ss(space.A, space.B, space.C, space.D, space.period_s)


def test_the_state_space_has_the_same_responses() -> None:
    loop = linearise(paper().evolve({"controller.delay_s": 2.7e-4, "controller.kp": 4.0}))
    space = loop.state_space()
    assert (space.inputs, space.outputs) == (("f_r", "d", "n"), ("f_a", "f_m", "u"))
    theirs = as_control(space)
    frequency = np.geomspace(1, 2499, 40)
    z = np.exp(2j * np.pi * frequency * TS)
    r = loop.responses(frequency)
    for k, name in enumerate(("f_a_from_f_r", "f_a_from_d", "f_a_from_n")):
        np.testing.assert_allclose(r[name], [theirs(point)[0, k] for point in z], rtol=1e-8)
    np.testing.assert_allclose(r["u_from_n"], [theirs(point)[2, 2] for point in z], rtol=1e-8)


def test_noise_covariance() -> None:
    """control.dlyap solves the same Lyapunov equation in another way (Slycot or SciPy's bilinear form)."""
    closed = linearise(paper()).state_space()
    theirs = as_control(closed)
    spread = control.dlyap(theirs.A, theirs.B[:, 2:] @ theirs.B[:, 2:].T)
    ours = closed.variance("n")
    np.testing.assert_allclose([ours["f_a"], ours["f_m"], ours["u"]], np.diag(theirs.C @ spread @ theirs.C.T))
