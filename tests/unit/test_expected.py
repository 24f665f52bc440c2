"""The reading that the model expects: against the differential equations, and by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import signal

import frictionloop as fl
from frictionloop.control.expected_reading import expected_gains, expected_start, expected_step

RATE, FINE = 5000.0, 60
DT = 1.0 / RATE
MODEL = fl.Model(nominal_n=0.95, resonance_hz=145.0)


def readings(controller, setpoints, low=-10.0, high=10.0):
    state, gains, out = expected_start(controller), expected_gains(controller), []
    for r in setpoints:
        out.append(state)
        state = expected_step(state, float(r), low, high, gains)
    return np.array(out)


def plate_force(controller, commands):
    """scipy.signal.lsim of the plate on a grid of FINE points per period, commands held and late by the delay."""
    late = round(controller.delay_s * RATE * FINE)
    held = np.concatenate([np.full(late, MODEL.nominal_n), np.repeat(commands, FINE)])[: len(commands) * FINE + 1]
    held = np.append(held, held[-1])[: len(commands) * FINE + 1]
    time = np.arange(held.size) * DT / FINE
    corner = 2 * math.pi * controller.model.plate_hz
    # A zero-order hold, as the command is one.
    return time, signal.lsim(([1.0], [1.0 / corner, 1.0]), held - MODEL.nominal_n, time, interp=False)[1]


def sensor_of(model):
    w = 2 * math.pi * model.resonance_hz
    springs = signal.TransferFunction([w * w], [1.0, w / model.resonance_q, w * w])
    den = np.polymul(springs.den, [1.0 / (2 * math.pi * model.sensor_hz), 1.0])
    return signal.TransferFunction(springs.num, den)


DELAYS = [0.0, 50e-6, 200e-6, 330e-6, 400e-6, 550e-6, 600e-6]


@pytest.mark.parametrize("delay_s", DELAYS)
def test_plate_and_its_mean_are_exact(delay_s):
    """Any delay up to three periods, on the set-points of a staircase; the mean by trapezoids over lsim's points."""
    controller = fl.NotchPiController(feedforward=True, delay_s=delay_s, model=MODEL)
    setpoints = np.random.default_rng(1).uniform(0.2, 0.9, 40)
    got = readings(controller, setpoints)
    _, force = plate_force(controller, setpoints)
    np.testing.assert_allclose(got[:, 4], 0.95 + force[:-1:FINE], atol=2e-13)
    # The springs see the mean over each period as held: lsim of the whole sensor with that.
    mean = np.array([np.trapezoid(force[k * FINE : (k + 1) * FINE + 1], dx=1 / FINE) for k in range(40)])
    sampled = signal.cont2discrete((sensor_of(MODEL).num, sensor_of(MODEL).den), DT, method="zoh")
    expected = signal.lfilter(np.ravel(sampled[0]), sampled[1], np.append(mean, 0.0))[:40]
    # Trapezoids over 60 points of exponentials of 0.126 periods^-1 err by (0.126/60)^2/12 of a jump.
    np.testing.assert_allclose(got[:, 7], 0.95 + expected, atol=1e-6)


@pytest.mark.parametrize("delay_s", DELAYS)
@pytest.mark.parametrize("overdrive", [False, True])
def test_reading_against_the_whole_plant(delay_s, overdrive):
    """lsim of plate, springs and pole in one; taking the force's mean errs by at most w^2 Ts^2/12 of all it moves."""
    controller = fl.NotchPiController(feedforward=True, overdrive=overdrive, delay_s=delay_s, model=MODEL)
    setpoints = np.repeat([0.75, 0.35, 0.6], 60)
    commands = setpoints
    if overdrive:
        p = math.exp(-2 * math.pi * MODEL.plate_hz * DT)
        before = np.append(MODEL.nominal_n, setpoints[:-1])
        commands = (setpoints - p * before) / (1 - p)
    got = readings(controller, setpoints)
    time, force = plate_force(controller, commands)
    whole = signal.lsim(sensor_of(MODEL), force, time)[1][:-1:FINE]
    bound = (2 * math.pi * 145.0 * DT) ** 2 / 12 * np.sum(np.abs(np.diff(np.append(0.95, setpoints))))
    assert np.max(np.abs(got[:, 7] - 0.95 - whole)) < bound
    assert bound < 0.003 * 0.85 * 2


def test_without_a_resonance_it_is_plate_and_pole():
    controller = fl.NotchPiController(feedforward=True, model=MODEL.model_copy(update={"resonance_hz": 0.0}))
    got = readings(controller, np.full(100, 0.5))
    a, b = 2 * math.pi * 100.0, 2 * math.pi * 1000.0
    t = np.arange(100) * DT
    # Two poles in series after a step, in closed form; the mean as held in front of the faster pole.
    step = 1 - (b * np.exp(-a * t) - a * np.exp(-b * t)) / (b - a)
    assert np.max(np.abs(got[:, 7] - (0.95 - 0.45 * step))) < 0.45 * a * DT * 0.08
    np.testing.assert_allclose(got[:, 4], 0.95 - 0.45 * (1 - np.exp(-a * t)), atol=1e-13)


@pytest.mark.parametrize("delay_s", [0.0, 200e-6, 500e-6])
def test_it_settles_on_the_setpoint_wherever_that_is(delay_s):
    """The error is then that against the set-point itself: no bias, also beyond the clamp."""
    for setpoint in (0.05, 0.5, 1.4):
        controller = fl.NotchPiController(feedforward=True, overdrive=True, delay_s=delay_s, model=MODEL)
        last = readings(controller, np.full(12000, setpoint), 0.1, 0.9)[-1]
        np.testing.assert_allclose(last[[3, 4, 5, 7]], setpoint, rtol=1e-12)


def test_overdrive_gets_there_in_one_period_and_saturates_like_the_plate():
    controller = fl.NotchPiController(feedforward=True, overdrive=True, model=MODEL)
    p = math.exp(-2 * math.pi * 100.0 * DT)
    small = readings(controller, [0.95, 0.9, 0.9], 0.1, 0.95)
    np.testing.assert_allclose(small[2, [3, 4]], 0.9, atol=1e-12)
    large = readings(controller, [0.95, 0.2, 0.2], 0.1, 0.95)  # wants less than 0.1 N: stays at 0.1 N
    np.testing.assert_allclose(large[2, [3, 4]], 0.1 + 0.85 * p, atol=1e-12)


def test_the_sensor_of_the_bench_reads_what_is_expected():
    """The simulator's plant under the believed plant: a rigid, smooth finger whose f0 and tau the model has right.

    The literal plant filters the amplitude and then forms the force; for steps of 2 % both are alike to second order.
    """
    steps = fl.Steps(times_s=(0.0, 0.5, 0.52, 0.55), levels_n=(0.6, 0.588, 0.6, 0.59))
    quiet = fl.bench().evolve(
        {"controller.kind": "notch_pi", "controller.kp": 0.0, "controller.ki": 0.0, "controller.feedforward": True,
         "setpoint": steps, "friction": fl.Friction(nominal_n=0.95), "finger.kind": "rigid", "motion.kind": "sliding",
         "sensor.noise_density_n_rthz": 0.0, "sensor.adc_bits": 32, "controller.delay_s": 330e-6}
    )  # fmt: skip
    for overdrive in (False, True):
        system = quiet.evolve({"controller.overdrive": overdrive})
        run = fl.simulate(system, 0.6)
        low = system.controller.model.floor_n
        got = readings(system.controller, run["f_r"].values, low, 0.95)[:, 7]
        after = slice(2400, 3000)
        moved = np.ptp(run["f_m"].values[after])
        assert moved > 0.012  # it rings: more than the steps
        assert np.max(np.abs(got - run["f_m"].values)[after]) < 0.03 * moved
