"""What is left of a disturbance in bands of frequency."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal.windows import tukey

import frictionloop as fl
from frictionloop.analysis import operating_band
from frictionloop.loop.band_residuals import rms_by_band

RATE_HZ = 5000.0
TIME_S = np.arange(10000) / RATE_HZ
TONES_HZ = (2.0, 30.0, 400.0)


def run_of(tones_hz, **changes):
    values_n = 0.1 + 2e-3 * sum(np.sin(2 * np.pi * each * TIME_S) for each in tones_hz)
    signals = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Samples(values_n=values_n, rate_hz=RATE_HZ)}
    gains = changes or {"controller.kp": 3.0, "controller.ki": 50.0}
    return fl.simulate(fl.feasible().evolve(signals | gains), 2.0)


def test_each_band_is_the_linear_loops_response_to_its_tone():
    run = run_of(TONES_HZ)
    found = fl.disturbance_left_by_band(run, [0, 10, 100, 1000], run.time.values >= 0.5)
    steady = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Constant(offset_n=0.1)}
    loop = operating_band(fl.feasible().evolve({**steady, "controller.kp": 3.0, "controller.ki": 50.0}))[0]
    size = np.abs(loop.frequency_response(TONES_HZ)["f_a_from_d"].values)
    np.testing.assert_allclose(found.values, size, rtol=0.05)
    assert found.low_hz.values.tolist() == [0, 10, 100] and found.high_hz.values.tolist() == [10, 100, 1000]


@pytest.mark.parametrize("shape", ["cosine", "noise and ramp"])
def test_a_disturbance_that_begins_and_ends_anywhere_is_left_as_the_linear_loop_leaves_it(shape):
    """A loop has not acted at t = 0: all of d is left there, which must not be taken for something slow."""
    drawn = np.random.default_rng(5).normal(size=(2, TIME_S.size)).cumsum(axis=1)
    d = {"cosine": np.cos(2 * np.pi * 2 * TIME_S), "noise and ramp": 0.02 * drawn[0] + 2.0 * TIME_S - 2.0}[shape]
    signal = fl.Samples(values_n=0.02 * d / d.std(), rate_hz=RATE_HZ)
    gains = {"controller.kp": 10.0, "controller.ki": 2.0}
    steady = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": signal, **gains}
    run = fl.simulate(fl.feasible().evolve(steady), 2.0)
    slow = fl.disturbance_left_by_band(run, [0, 1, 4, 20]).values
    assert np.nanmax(np.abs(slow - 1 / 11)) < 0.02


def test_an_open_loop_leaves_all_and_a_band_without_anything_has_no_share():
    run = run_of(TONES_HZ[:2], **{"controller.kind": "lookup"})
    found = fl.disturbance_left_by_band(run, [0, 10, 100, 1000]).values
    np.testing.assert_allclose(found[:2], 1.0, atol=1e-9)
    assert np.isnan(found[2])
    constant = fl.simulate(fl.feasible().evolve({"disturbance": fl.Constant(offset_n=0.1)}), 0.5)
    assert np.isnan(fl.disturbance_left_by_band(constant, [0, 10])).all()


EDGES = st.lists(st.floats(0.5, 2400.0), min_size=1, max_size=6, unique=True)


@given(EDGES, st.integers(0, 2**16), st.integers(50, 400))
def test_squares_of_bands_from_0_on_add_up_to_those_of_the_windowed_signal(inner_hz, seed, samples):
    values, time_s = np.cumsum(np.random.default_rng(seed).normal(size=samples)), np.arange(samples) / RATE_HZ
    parts = rms_by_band(values, time_s, slice(None), [0.0, *sorted(inner_hz), np.inf])
    window = tukey(samples, 0.2, sym=False)
    shown = window * (values - values.mean())
    power = (np.sum(shown**2) - np.sum(shown) ** 2 / samples) / np.sum(window**2)
    assert np.sqrt(np.sum(parts**2)) == pytest.approx(np.sqrt(power), rel=1e-6)


SLOW = {
    "a ramp": TIME_S / TIME_S[-1] - 0.5,
    "half a sine": np.sin(np.pi * TIME_S / TIME_S[-1]),
    "a step": 1.0 / (1.0 + np.exp(-(TIME_S - 1.0) / 0.02)),
}


@pytest.mark.parametrize("shape", SLOW)
@pytest.mark.parametrize("seconds", [1.35, 2.0])
def test_what_is_slow_and_larger_moves_no_faster_band(shape, seconds):
    """A tone of 3 mN rms at 100 Hz, beside a trend of 60 mN: in the signal, and in what a loop leaves of it."""
    some, edges_hz = seconds >= TIME_S, [0.0, 5.0, 40.0, 2500.0]
    tone = 3.0 * np.sqrt(2) * np.sin(2 * np.pi * 100 * TIME_S)
    fast = rms_by_band((tone + 60.0 * SLOW[shape])[some], TIME_S[some], slice(None), edges_hz)[2]
    assert fast == pytest.approx(3.0, rel=0.02)


def test_the_rms_is_that_of_a_sine_and_gaps_are_bridged():
    edges_hz = [0.0, 20.0, 100.0, 2500.0]
    values = 3.0 + 0.2 * np.sin(2 * np.pi * 50 * TIME_S)
    below, there, above = rms_by_band(values, TIME_S, slice(None), edges_hz)
    assert there == pytest.approx(0.2 / np.sqrt(2), rel=1e-3) and max(below, above) < 0.01 * there
    keep = np.ones(TIME_S.size, bool)
    keep[4000:4004] = False
    bridged = rms_by_band(np.where(keep, values, 50.0), TIME_S, keep, edges_hz)
    np.testing.assert_allclose(bridged, [below, there, above], atol=2e-4)


@pytest.mark.parametrize("middle", [0.2, 0.5, 0.8])
def test_a_burst_counts_by_its_power_wherever_it_is(middle):
    """By Parseval; beside a slow part that is there all the time."""
    burst = np.where(np.abs(TIME_S / TIME_S[-1] - middle) < 0.05, np.random.default_rng(0).normal(size=TIME_S.size), 0)
    slow = np.sin(2 * np.pi * 5 * TIME_S)
    below, above = rms_by_band(slow + burst, TIME_S, slice(None), [0.0, 20.0, np.inf])
    assert below == pytest.approx(np.std(slow), rel=0.05) and above == pytest.approx(np.std(burst), rel=0.1)


def test_the_force_of_each_band_stands_beside_its_share():
    run = run_of(TONES_HZ[:1])
    found = fl.disturbance_left_by_band(run, [0, 10, 100, 1000])
    there = np.isfinite(found.values)
    np.testing.assert_allclose((found.left_n / found.disturbance_n).values[there], found.values[there], rtol=1e-12)
    assert float(found.disturbance_n.sum()) == pytest.approx(float(run.d.std()), rel=0.05)
