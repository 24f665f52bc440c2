"""The force sensor, through the simulator, against closed forms of a first-order low-pass."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import lfilter

import frictionloop as fl
from frictionloop.quantities.counter_noise import normals
from frictionloop.sensing.force_sensor import linearise_sensor

# A finger that vibration does not move: the force on it is f0 + d(t) alone.
DEAD = {"friction.susceptibility_per_um2": 1e-30, "setpoint": fl.Constant(offset_n=0.5), "sensor.noise_rms_n": 0.0}
F0 = 0.8
# Readings near 1 N, a dozen roundings per period, forgotten with the sensor's time constant; and weights that hold to
# 1e-13 (test_quadrature).
ROUNDING = 2e-13


def measured(overrides, duration_s=0.1, seed=0):
    system = fl.paper().evolve(DEAD | overrides)
    run = fl.simulate(system, duration_s, seed)
    return run["time"].values, run["f_m"].values, 2 * math.pi * system.sensor.cutoff_hz


RATES = [(5000.0, 1000.0), (5000.0, 20.0), (1000.0, 1000.0), (200.0, 1000.0), (5000.0, 1e5)]


@pytest.mark.parametrize(("rate_hz", "cutoff_hz"), RATES)
def test_a_constant_force_is_read_as_it_is(rate_hz, cutoff_hz):
    _, f_m, _ = measured(
        {"disturbance": fl.Constant(offset_n=0.3), "controller.rate_hz": rate_hz, "sensor.cutoff_hz": cutoff_hz}
    )
    np.testing.assert_allclose(f_m, F0 + 0.3, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(("rate_hz", "cutoff_hz"), RATES)
def test_step_response(rate_hz, cutoff_hz):
    step = fl.Steps(times_s=(0.0, 0.02), levels_n=(0.1, 0.5))
    t, f_m, omega = measured({"disturbance": step, "controller.rate_hz": rate_hz, "sensor.cutoff_hz": cutoff_hz})
    exact = F0 + 0.1 - 0.4 * np.expm1(-omega * np.maximum(t - 0.02, 0.0))
    np.testing.assert_allclose(f_m, exact, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(("cutoff_hz", "frequency_hz"), [(1000.0, 10.0), (1000.0, 100.0), (100.0, 100.0), (2e4, 100.0)])
def test_response_to_a_sine(cutoff_hz, frequency_hz):
    """f_m' = ws (f - f_m), f = f0 + b + A sin(w t): steady state A |S| sin(w t + arg S) and a decaying rest."""
    sine = fl.Sine(offset_n=0.2, amplitude_n=0.2, frequency_hz=frequency_hz)
    t, f_m, omega = measured({"disturbance": sine, "sensor.cutoff_hz": cutoff_hz})
    response = linearise_sensor(fl.LowpassSensor(cutoff_hz=cutoff_hz))[0].response(frequency_hz)
    steady = 0.2 * abs(response) * np.sin(2 * np.pi * frequency_hz * t + np.angle(response))
    exact = F0 + 0.2 + steady - steady[0] * np.exp(-omega * t)
    # Six nodes interpolate the sine over a period T: the error is max |f^(6)| / 6! times the largest value of the
    # node polynomial on [0, T], 3.2e-4 T^6, so 0.2 (2 pi 100 / 5000)^6 * 3.2e-4 / 720 = 4e-13 N.
    bound = 0.2 * (2 * np.pi * frequency_hz / 5000) ** 6 * 3.2e-4 / 720
    np.testing.assert_allclose(f_m, exact, rtol=0, atol=bound + ROUNDING)


def test_straight_lines_between_samples(tmp_path):
    """A recording is linear between its samples; so is the closed form of one period for a ramp."""
    values = 0.2 + 0.1 * normals(1, 9, 0, 501)
    path = tmp_path / "force.csv"
    np.savetxt(path, values, fmt="%.17g")
    t, f_m, omega = measured({"disturbance": fl.Recording(path=str(path), rate_hz=5000.0)})
    exact, period = [F0 + values[0]], 1 / 5000
    for start, end in itertools.pairwise(values):
        slope = (end - start) / period  # f_m = f - slope/ws + (f_m(0) - f(0) + slope/ws) e^(-ws T)
        exact.append(F0 + end - slope / omega + (exact[-1] - F0 - start + slope / omega) * math.exp(-omega * period))
    np.testing.assert_allclose(f_m, exact[: t.size], rtol=0, atol=ROUNDING)


def test_the_whole_plant_after_a_held_command():
    """kp = ki = 0 holds a_max: a(t), g(a(t)) and the sensor's convolution, by adaptive quadrature of closed forms."""
    system = fl.paper().evolve(
        {
            "controller.kp": 0.0,
            "controller.ki": 0.0,
            "sensor.noise_rms_n": 0.0,
            "disturbance": fl.Constant(offset_n=0.1),
        }
    )
    run = fl.simulate(system, 0.02)
    wc, ws = 2 * math.pi * 100.0, 2 * math.pi * 1000.0

    def force(s):
        return 0.8 * math.exp(-0.38 * (2.5 * -math.expm1(-wc * s)) ** 2) + 0.1

    np.testing.assert_allclose(run["f_a"].values, [force(s) for s in run["time"].values], rtol=0, atol=ROUNDING)
    for k in (1, 2, 10, 99):
        t = float(run["time"][k])
        integral = sum(
            quad(lambda s, t=t: ws * math.exp(-ws * (t - s)) * force(s), a, b, epsabs=1e-14, epsrel=1e-13)[0]
            for a, b in itertools.pairwise(np.linspace(0, t, k + 1))
        )
        # quad keeps 1e-14 per period; the simulator's rule leaves up to 3e-10 of a swing of 2.5 um (as in
        # test_friction_limit) where the amplitude starts to rise.
        assert float(run["f_m"][k]) == pytest.approx(force(0.0) * math.exp(-ws * t) + integral, abs=3e-10)


def test_noise_enters_before_the_low_pass():
    """With a constant force the reading is f + AR(1): x_(k+1) = q x_k + (1 - q) n_k, n_k the normals of stream 0."""
    t, f_m, omega = measured(
        {"disturbance": fl.Constant(offset_n=0.3), "sensor.noise_rms_n": 0.01}, duration_s=1.0, seed=11
    )
    q = math.exp(-omega / 5000)
    noise = 0.01 * normals(11, 0, 0, t.size)
    exact = F0 + 0.3 + lfilter([0.0, 1 - q], [1.0, -q], noise)
    np.testing.assert_allclose(f_m, exact, rtol=0, atol=ROUNDING)
    # Its variance in closed form: (1 - q)^2 / (1 - q^2). The estimate's relative error is sqrt(2/N (1+q^2)/(1-q^2)).
    variance = 0.01**2 * (1 - q) / (1 + q)
    error = math.sqrt(2 / t.size * (1 + q * q) / (1 - q * q))
    assert f_m.var() == pytest.approx(variance, rel=5 * error)


def test_frequency_response():
    sensor = linearise_sensor(fl.paper().sensor)[0]
    assert sensor.response(0.0) == 1.0
    assert abs(sensor.response(1000.0)) == pytest.approx(math.sqrt(0.5), rel=1e-14)
    assert np.angle(sensor.response(1000.0)) == pytest.approx(-math.pi / 4, rel=1e-14)
