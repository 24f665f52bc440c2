"""The whole loop where it has a closed form: the first sample, and where it comes to rest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import frictionloop as fl

QUIET = fl.feasible().evolve({"sensor.noise_rms_n": 0.0, "disturbance": fl.Constant(offset_n=0.1)})
FLOOR = 0.8 * math.exp(-0.38 * 6.25)
reachable_force = st.floats(0.25, 0.85)  # inside [FLOOR + 0.1, 0.9]
gain = st.floats(0.1, 10.0)


def at_rest(overrides, duration_s=1.0):
    """Return the last row, having checked that nothing moves any more."""
    run = fl.simulate(QUIET.evolve(overrides), duration_s)
    end = run.isel(time=slice(-100, None))
    for name in ("f_a", "f_m", "u"):
        # The slowest pole, (1 + kp) / ki <= 55 ms, has decayed to e^-18 = 1e-8 of a newton at most.
        assert np.ptp(end[name].values) < 1e-8
    return {name: float(run[name].values[-1]) for name in run.data_vars}


@settings(max_examples=30)
@given(reachable_force, gain, st.floats(200.0, 500.0), st.sampled_from([0.0, 100e-6, 250e-6]))
def test_with_an_integral_the_force_becomes_the_set_point(force, kp, ki, delay_s):
    kp = kp / 2 if delay_s else kp  # a delay costs phase
    last = at_rest(
        {
            "setpoint": fl.Constant(offset_n=force),
            "controller.kp": kp,
            "controller.ki": ki,
            "controller.delay_s": delay_s,
        }
    )
    assert last["f_m"] == pytest.approx(force, abs=1e-7)
    assert last["f_a"] == pytest.approx(force, abs=1e-7)
    assert last["u"] == pytest.approx(force - 0.1, abs=1e-7)
    assert 0.8 * math.exp(-0.38 * last["a"] ** 2) == pytest.approx(force - 0.1, abs=1e-7)
    assert not last["saturated"]


@settings(max_examples=30)
@given(st.floats(0.4, 0.7), st.floats(2.0, 10.0))
def test_without_an_integral_a_share_of_the_error_stays(force, kp):
    """u = kp (r - f) and f = u + d give f = (kp r + d) / (1 + kp), if u is within its clamp."""
    last = at_rest({"setpoint": fl.Constant(offset_n=force), "controller.kp": kp, "controller.ki": 0.0})
    exact = (kp * force + 0.1) / (1 + kp)
    assert FLOOR < kp * (force - exact) < 0.8
    assert last["f_a"] == pytest.approx(exact, abs=1e-10)
    assert last["f_m"] == pytest.approx(exact, abs=1e-10)


@settings(max_examples=30)
@given(st.floats(0.4, 0.7), st.floats(2.0, 5.0), st.floats(0.7, 1.1), st.floats(0.3, 0.5))
def test_a_wrong_model_shifts_the_rest(force, kp, believed_n, believed_tau):
    """f = g(a(u)) + d with a(u) by the model: one equation, solved by bisection."""
    last = at_rest(
        {
            "setpoint": fl.Constant(offset_n=force),
            "controller.kp": kp,
            "controller.ki": 0.0,
            "controller.model.nominal_n": believed_n,
            "controller.model.susceptibility_per_um2": believed_tau,
        }
    )

    def miss(f):
        u = min(max(kp * (force - f), believed_n * math.exp(-believed_tau * 6.25)), believed_n)
        a = min(math.sqrt(math.log(believed_n / u) / believed_tau), 2.5)
        return 0.8 * math.exp(-0.38 * a * a) + 0.1 - f

    assert last["f_a"] == pytest.approx(brentq(miss, 0.0, 2.0, xtol=1e-13), abs=1e-9)


@pytest.mark.parametrize(("force", "reached", "a"), [(5.0, 0.9, 0.0), (-5.0, FLOOR + 0.1, 2.5)])
def test_an_unreachable_set_point_ends_at_the_clamp(force, reached, a):
    last = at_rest({"setpoint": fl.Constant(offset_n=force), "controller.ki": 100.0})
    assert last["f_a"] == pytest.approx(reached, abs=1e-12)
    assert last["a"] == pytest.approx(a, abs=1e-12)
    assert last["saturated"]


def test_a_step_of_the_disturbance_is_removed():
    step = fl.Steps(times_s=(0.0, 0.5), levels_n=(0.1, 0.3))
    run = fl.simulate(
        QUIET.evolve({"disturbance": step, "setpoint": fl.Constant(offset_n=0.6), "controller.ki": 500.0}), 1.0
    )
    f_a = run["f_a"].values
    assert f_a[2500] == pytest.approx(f_a[2499] + 0.2, abs=1e-9)  # it lands on its sample, before any reaction
    assert f_a[-1] == pytest.approx(0.6, abs=1e-7)


def test_time_runs_from_0_in_control_periods():
    run = fl.simulate(QUIET, 0.01)
    np.testing.assert_array_equal(run["time"].values, np.arange(50) / 5000.0)


def test_the_command_waits_for_the_delay():
    """The amplitude is 0 until the first command is applied, then rises as 1 - e^(-wc t)."""
    system = QUIET.evolve({"controller.kp": 0.0, "controller.ki": 0.0, "controller.delay_s": 730e-6})
    run = fl.simulate(system, 0.01)
    t = run["time"].values
    exact = -2.5 * np.expm1(-2 * np.pi * 100 * np.maximum(t - 730e-6, 0.0))
    np.testing.assert_allclose(run["a"].values, exact, rtol=0, atol=1e-14)
    assert np.count_nonzero(run["a"].values == 0.0) == 4  # t = 0, 0.2, 0.4 and 0.6 ms


@pytest.mark.parametrize(
    ("disturbance", "first"),
    [
        (fl.Constant(offset_n=0.25), 0.25),
        (fl.Sine(offset_n=0.25, amplitude_n=0.1, frequency_hz=7.0), 0.25),
        (fl.Steps(times_s=(0.0, 0.1), levels_n=(0.25, 0.7)), 0.25),
    ],
)
def test_at_t_0_the_plate_rests_and_the_sensor_has_settled(disturbance, first):
    run = fl.simulate(fl.paper().evolve({"disturbance": disturbance, "controller.kp": 0.5}), 0.01).isel(time=0)
    assert float(run["a"]) == 0.0
    assert float(run["d"]) == first
    assert float(run["f_a"]) == pytest.approx(0.8 + first, abs=1e-15)
    assert float(run["f_m"]) == float(run["f_a"])
    assert float(run["f_r"]) == 0.6
    # The integral is 0, so v = kp e = 0.5 (0.6 - 1.05) lies below the clamp.
    assert float(run["u"]) == pytest.approx(FLOOR, rel=1e-14)
    assert bool(run["saturated"])
