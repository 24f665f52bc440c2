"""What no run may ever do, searched for over the parameter space."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import freqs

import frictionloop as fl
from frictionloop.quantities import Lti

force = st.floats(-2.0, 2.0)
PERIODS = 150


@st.composite
def signals(draw, rate_hz):
    kind = draw(st.sampled_from(["constant", "sine", "log_sweep", "steps", "noise"]))
    offset, amplitude = draw(force), draw(st.floats(0, 2))
    if kind == "constant":
        return fl.Constant(offset_n=offset)
    if kind == "sine":
        return fl.Sine(offset_n=offset, amplitude_n=amplitude, frequency_hz=draw(st.floats(0.01, 0.4)) * rate_hz)
    if kind == "log_sweep":
        ends = draw(st.tuples(st.floats(1e-3, 0.2), st.floats(0.201, 0.4)))
        return fl.LogSweep(
            offset_n=offset, amplitude_n=amplitude, start_hz=ends[0] * rate_hz, stop_hz=ends[1] * rate_hz,
            sweep_s=PERIODS / rate_hz,
        )  # fmt: skip
    if kind == "steps":
        times = draw(st.lists(st.integers(1, PERIODS), max_size=4, unique=True))
        return fl.Steps(
            times_s=(0.0, *(k / rate_hz for k in sorted(times))), levels_n=(offset, *(draw(force) for _ in times))
        )
    return fl.ColouredNoise(
        offset_n=offset, rms_n=amplitude / 3, exponent=draw(st.floats(0, 2)),
        low_hz=0.001 * rate_hz, high_hz=draw(st.floats(0.002, 2)) * rate_hz,
    )  # fmt: skip


@st.composite
def systems(draw):
    rate_hz = draw(st.sampled_from([200.0, 1000.0, 5000.0, 40000.0]))
    top_um = draw(st.floats(0.01, 10))
    fall = draw(st.floats(0.01, 700))  # tau a_max^2
    return fl.System(
        setpoint=draw(signals(rate_hz)),
        disturbance=draw(signals(rate_hz)),
        friction=fl.Friction(nominal_n=draw(st.floats(0.05, 5)), susceptibility_per_um2=fall / top_um**2 * 0.999),
        plate=fl.LowpassPlate(cutoff_hz=draw(st.floats(1e-4, 0.9)) * rate_hz, max_amplitude_um=top_um),
        sensor=fl.LowpassSensor(cutoff_hz=draw(st.floats(1e-3, 100)) * rate_hz, noise_rms_n=draw(st.floats(0, 1))),
        controller=fl.PiController(
            kp=draw(st.sampled_from([0.0, 1e-3, 1.0, 10.0, 40.0, 1e6])),
            ki=draw(st.sampled_from([0.0, 2.0, 1e3, 1e9])),
            rate_hz=rate_hz,
            delay_s=draw(st.sampled_from([0.0, 0.3, 1.0, 1.5, 20.0])) / rate_hz,
            model=fl.Model(
                nominal_n=draw(st.floats(0.05, 5)),
                susceptibility_per_um2=draw(st.floats(0.01, 5)),
                max_amplitude_um=draw(st.floats(0.05, 10)),
                table_size=draw(st.sampled_from([0, 2, 3, 100])),
            ),
        ),
    )


@settings(max_examples=400)
@given(systems(), st.integers(0, 2**64 - 1))
def test_every_run_stays_where_physics_and_the_controller_allow(system, seed):
    run = fl.simulate(system, PERIODS / system.controller.rate_hz, seed)
    f_r, f_a, f_m, u, a, d = (run[name].values for name in ("f_r", "f_a", "f_m", "u", "a", "d"))
    for name in run.data_vars:
        assert np.all(np.isfinite(run[name].values)), name
    # The friction force is g(a) + d, and vibration can lower g from f0 to g(a_max) and no further.
    friction = system.friction
    floor = friction.nominal_n * math.exp(-friction.susceptibility_per_um2 * system.plate.max_amplitude_um**2)
    rounding = 1e-12  # asked for; forces are below 10 N
    assert np.all(f_a - d >= floor - rounding)
    assert np.all(f_a - d <= friction.nominal_n + rounding)
    # The amplitude approaches commands between 0 and a_max as a convex combination, rounded.
    top = system.plate.max_amplitude_um
    assert np.all((a >= 0) & (a <= top * (1 + PERIODS * 2.0**-52)))
    np.testing.assert_allclose(f_a - d, fl.friction_force(a, friction), rtol=0, atol=1e-12)
    # The command lies in the clamp of the controller's model, ends included, exactly.
    c = system.controller
    low, high = c.model.floor_n, c.model.nominal_n
    assert np.all((u >= low) & (u <= high))
    check_command(c, f_r - f_m, u, run["saturated"].values, low, high)


def check_command(c, error, u, saturated, low, high):
    """Run the PI law beside the recorded one: u = clip(v), and ``saturated`` says that v lay outside."""
    integral = 0.0
    for k, e in enumerate(error.tolist()):
        v = c.kp * e + integral
        # The recorded law rounds once where this one rounds twice, at the size of its terms.
        slack = 1e-11 * (abs(c.kp * e) + abs(integral) + abs(c.ki * e) * PERIODS / c.rate_hz + 1e-3)
        assert abs(u[k] - min(max(v, low), high)) <= slack
        if not (low - slack <= v <= low + slack or high - slack <= v <= high + slack):
            assert saturated[k] == (v < low or v > high)
        if saturated[k]:
            assert u[k] in (low, high)
            inwards = e <= 0 if u[k] == high else e >= 0
            integral += c.ki / c.rate_hz * e * inwards
        else:
            integral += c.ki / c.rate_hz * e


@settings(max_examples=50)
@given(systems(), st.integers(0, 1000))
def test_a_run_is_the_beginning_of_a_longer_one(system, seed):
    short, long = (fl.simulate(system, n / system.controller.rate_hz, seed) for n in (PERIODS // 2 + 1, PERIODS))
    for name in short.data_vars:
        np.testing.assert_array_equal(short[name].values, long[name].values[: short.sizes["time"]])


@settings(max_examples=50)
@given(systems(), st.integers(0, 1000))
def test_the_same_run_twice_has_the_same_bits(system, seed):
    duration_s = PERIODS / system.controller.rate_hz
    assert fl.simulate(system, duration_s, seed).identical(fl.simulate(system, duration_s, seed))


FREQUENCY_HZ = np.geomspace(0.1, 1e4, 60)
coefficient = st.floats(0.01, 100)
polynomial = st.lists(coefficient, min_size=1, max_size=4).map(tuple)
# Positive coefficients, degree 1 or 2: every root lies left of the imaginary axis, so H is finite on it.
system = st.builds(
    Lti, polynomial, st.lists(coefficient, min_size=2, max_size=3).map(tuple), st.floats(0, 1e-2, allow_subnormal=False)
)


@given(system)
def test_response_equals_scipys(lti):
    _, rational = freqs(lti.num, lti.den, 2 * np.pi * FREQUENCY_HZ)
    expected = rational * np.exp(-2j * np.pi * FREQUENCY_HZ * lti.delay_s)
    # Both evaluate the same polynomials; 1e-12 leaves room for Horner's rule in another order.
    np.testing.assert_allclose(lti.response(FREQUENCY_HZ), expected, rtol=1e-12)


@given(system, system)
def test_series_connection_multiplies_responses(one, other):
    both = (one * other).response(FREQUENCY_HZ)
    # The product polynomial has up to 6 terms, each rounded; near the imaginary axis roots lose a few digits.
    np.testing.assert_allclose(both, one.response(FREQUENCY_HZ) * other.response(FREQUENCY_HZ), rtol=1e-8)


def test_a_pure_delay_turns_the_phase_only():
    delay = Lti((1.0,), (1.0,), 1e-3)
    assert delay.response(np.array([250.0]))[0] == pytest.approx(-1j, abs=1e-15)  # a quarter of 4 ms


def test_scalars_and_arrays_of_any_shape():
    lowpass = Lti((1.0,), (1.0 / (2 * np.pi * 100.0), 1.0))
    assert lowpass.response(0.0) == 1.0
    assert abs(lowpass.response(100.0)) ** 2 == pytest.approx(0.5, rel=1e-14)
    assert lowpass.response(np.ones((2, 3))).shape == (2, 3)


def test_it_is_a_value():
    lti = Lti((1.0,), (1.0, 2.0))
    assert lti == Lti((1.0,), (1.0, 2.0))
    with pytest.raises(dataclasses.FrozenInstanceError):
        lti.delay_s = 1.0
