"""Set-points and disturbances over time: formulas, sampled signals, and the simulator's traces of both."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.physics.signal_values import evaluate, sampler

RATE_HZ = 5000.0
T = np.arange(1000) / RATE_HZ


def traced(source, seed=0):
    """Return the source as set-point and as disturbance of a run."""
    run = fl.simulate(fl.paper().evolve({"setpoint": source, "disturbance": source}), T.size / RATE_HZ, seed)
    return run["f_r"].values, run["d"].values


# A phase of 2 pi times so many turns is rounded to 2^-52 of itself.
def rounding(amplitude_n, turns):
    return amplitude_n * 2 * np.pi * max(turns, 1.0) * 4 * 2.0**-52 + 4 * 2.0**-52


def test_constant():
    for got in (evaluate(fl.Constant(offset_n=0.3), T), *traced(fl.Constant(offset_n=0.3))):
        np.testing.assert_array_equal(got, np.full(T.size, 0.3))


@pytest.mark.parametrize("frequency_hz", [0.3, 1.0, 97.0, 2400.0])
def test_sine(frequency_hz):
    sine = fl.Sine(offset_n=0.5, amplitude_n=0.2, frequency_hz=frequency_hz)
    exact = [0.5 + 0.2 * math.sin(2 * math.pi * math.fmod(frequency_hz * t, 1.0)) for t in T]
    for got in (evaluate(sine, T), *traced(sine)):
        np.testing.assert_allclose(got, exact, rtol=0, atol=rounding(0.2, frequency_hz * T[-1]))


@pytest.mark.parametrize(("start_hz", "stop_hz"), [(1.0, 100.0), (100.0, 1.0), (3.0, 3.1)])
def test_log_sweep(start_hz, stop_hz):
    sweep = fl.LogSweep(offset_n=0.5, amplitude_n=0.2, start_hz=start_hz, stop_hz=stop_hz, sweep_s=0.25)
    growth = math.log(stop_hz / start_hz) / 0.25
    turns = start_hz * np.expm1(growth * T) / growth  # the integral of start e^(growth t)
    exact = 0.5 + 0.2 * np.sin(2 * np.pi * turns)
    # expm1 keeps digits that 2^x - 1 loses for a narrow sweep: absolute 2^-52 times start / growth.
    lost = 0.2 * 2 * np.pi * start_hz / abs(growth) * 2.0**-50
    for got in (evaluate(sweep, T), *traced(sweep)):
        np.testing.assert_allclose(got, exact, rtol=0, atol=rounding(0.2, turns.max()) + lost)


def test_a_sweep_takes_equal_time_per_octave_between_its_ends():
    sweep = fl.LogSweep(offset_n=0.0, amplitude_n=1.0, start_hz=2.0, stop_hz=64.0, sweep_s=5.0)
    t = np.linspace(0.0, 5.0, 2_000_001)
    rising = t[1:][np.diff(np.sign(evaluate(sweep, t))) > 0]  # one zero crossing per turn
    frequency = 1.0 / np.diff(rising)
    middle = (rising[1:] + rising[:-1]) / 2
    octaves = np.log2(frequency)
    # One octave per second, from 2 Hz. A turn's mean frequency is that of its middle to second order: ln2^2/24 of
    # its relative width squared, largest for the first turns of half a second.
    np.testing.assert_allclose(octaves, 1.0 + middle, rtol=0, atol=0.02)
    assert np.abs(octaves - 1.0 - middle)[-20:].max() < 1e-3


def test_steps_land_on_the_first_period_at_or_after_their_time():
    steps = fl.Steps(times_s=(0.0, 0.01, 0.0501, 0.1), levels_n=(0.1, 0.4, 0.2, 0.3))
    exact = np.full(T.size, 0.1)
    exact[50:] = 0.4  # 0.01 s is sample 50
    exact[251:] = 0.2  # 0.0501 s lies between 250 and 251
    exact[500:] = 0.3
    for got in traced(steps):
        np.testing.assert_array_equal(got, exact)
    np.testing.assert_array_equal(evaluate(steps, [0.0, 0.00999, 0.01, 0.0501, 7.0]), [0.1, 0.1, 0.4, 0.2, 0.3])


def test_a_recording_is_followed_sample_by_sample(tmp_path):
    path = tmp_path / "force.csv"
    values = np.cos(np.arange(T.size + 5) / 9.0)
    np.savetxt(path, values, fmt="%.17g")
    source = fl.Recording(path=str(path), rate_hz=RATE_HZ, scale=0.1, offset_n=0.5)
    for got in traced(source):
        np.testing.assert_allclose(got, 0.5 + 0.1 * values[: T.size], rtol=1e-15)


def test_noise_of_set_point_disturbance_and_sensor_are_different_streams():
    noise = fl.ColouredNoise(offset_n=0.4, rms_n=0.1, exponent=0.0, low_hz=1.0, high_hz=1e4)
    f_r, d = traced(noise, seed=3)
    again_r, again_d = traced(noise, seed=3)
    np.testing.assert_array_equal((f_r, d), (again_r, again_d))
    other_r, other_d = traced(noise, seed=4)
    pairs = [(f_r, d), (f_r, other_r), (d, other_d), (f_r, other_d)]
    for one, other in pairs:
        # 1000 nearly white samples: the correlation has a standard error of 1/sqrt(1000) = 0.03.
        assert abs(np.corrcoef(one, other)[0, 1]) < 0.16
    assert f_r.std() == pytest.approx(0.1, rel=0.15)  # 5 / sqrt(2 * 1000) = 0.11


kinds = st.sampled_from(
    [
        fl.ColouredNoise(offset_n=0.4, rms_n=0.1, exponent=1.0),
        fl.Steps(times_s=(0.0, 0.003, 0.0071), levels_n=(1.0, 2.0, 3.0)),
    ]
)


@given(kinds, st.lists(st.integers(1, 40), min_size=1, max_size=5), st.integers(0, 2**64 - 1))
def test_adjoining_chunks_share_their_common_sample(source, sizes, seed):
    edges = np.cumsum([0, *sizes]).tolist()
    whole = sampler(source, RATE_HZ, seed, 2)(0, edges[-1])
    take = sampler(source, RATE_HZ, seed, 2)
    for start, stop in itertools.pairwise(edges):
        np.testing.assert_array_equal(take(start, stop), whole[start : stop + 1])


def test_formulas_need_no_sampler():
    for source in (fl.Constant(), fl.Sine(), fl.LogSweep()):
        assert sampler(source, RATE_HZ, 0, 1) is None
    assert fl.LogSweep(sweep_s=3.0).longest_s == 3.0
    assert fl.Sine().longest_s == math.inf
