"""What is left of a disturbance in bands of frequency."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.analysis import operating_band
from frictionloop.loop.bands import in_band

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


def test_an_open_loop_leaves_all_and_a_band_without_anything_has_no_share():
    run = run_of(TONES_HZ[:2], **{"controller.kind": "lookup"})
    found = fl.disturbance_left_by_band(run, [0, 10, 100, 1000]).values
    np.testing.assert_allclose(found[:2], 1.0, atol=1e-9)
    assert np.isnan(found[2])
    constant = fl.simulate(fl.feasible().evolve({"disturbance": fl.Constant(offset_n=0.1)}), 0.5)
    assert np.isnan(fl.disturbance_left_by_band(constant, [0, 10])).all()


@given(
    st.lists(st.floats(0.5, 2400.0), min_size=1, max_size=6, unique=True), st.integers(0, 2**16), st.integers(50, 400)
)
def test_bands_from_0_on_add_up_to_the_signal(inner_hz, seed, samples):
    values = np.cumsum(np.random.default_rng(seed).normal(size=samples))
    edges = [0.0, *sorted(inner_hz), np.inf]
    parts = [in_band(values, np.arange(samples) / RATE_HZ, *band) for band in itertools.pairwise(edges)]
    np.testing.assert_allclose(sum(parts), values, atol=1e-9 * np.abs(values).max())


@pytest.mark.parametrize("edges_hz", [[1.0], [10, 4], [-1, 4], [0, 0, 1], 4.0])
def test_edges_that_do_not_rise_are_refused(edges_hz):
    with pytest.raises(fl.FrictionloopError, match=r"edges_hz = .*: must rise from 0 or above"):
        fl.disturbance_left_by_band(run_of(TONES_HZ[:1]), edges_hz)
