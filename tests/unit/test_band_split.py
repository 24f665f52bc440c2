"""What a loop leaves of a signal below and above a frequency, against the linear loop."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis import operating_band
from frictionloop.loop.band_split import (
    amplified_from_hz,
    by_band,
    disturbance_split,
    of_bands,
    split_edges,
)

RATE_HZ = 5000.0
TIME_S = np.arange(15000) / RATE_HZ
LEVEL = {"setpoint": fl.Constant(offset_n=0.5)}


def tones(*tones_hz, size_n=2e-3):
    values_n = size_n * sum((np.sin(2 * np.pi * each * TIME_S) for each in tones_hz), start=0 * TIME_S)
    return fl.Samples(values_n=values_n, rate_hz=RATE_HZ)


def disturbed(*tones_hz, duration_s=1.0, **changes):
    return fl.simulate(fl.feasible().evolve(LEVEL | {"disturbance": tones(*tones_hz)} | changes), duration_s)


@pytest.mark.parametrize("split_hz", [(8, 4), (0,), (-1,), (8, 8), (2500,), (math.nan,)])
def test_frequencies_that_do_not_rise_within_the_loops_are_refused(split_hz):
    with pytest.raises(fl.FrictionloopError, match="split_hz"):
        split_edges(split_hz, RATE_HZ)
    assert split_edges((), RATE_HZ) == []
    assert split_edges((8, 20), RATE_HZ) == [0.0, 8.0, 20.0, math.inf]


@pytest.mark.parametrize(("kp", "ki"), [(10.0, 2.0), (3.0, 50.0)])
def test_the_parts_of_a_disturbance_are_those_of_the_linear_loop(kp, ki):
    low_hz, high_hz = 20.0, 1000.0
    gains = {"controller.kp": kp, "controller.ki": ki}
    run = disturbed(low_hz, high_hz, **gains)
    settled = run.time.values >= 0.2
    split = disturbance_split(run, settled)
    assert low_hz < split.amplified_from_hz < high_hz and split.amplified_from_hz == amplified_from_hz(run, settled)
    loop = operating_band(fl.feasible().evolve({**LEVEL, "disturbance": fl.Constant(), **gains}))[0]
    at_hz = [low_hz, 0.98 * split.amplified_from_hz, 1.02 * split.amplified_from_hz, high_hz]
    response = loop.frequency_response(at_hz)
    size = np.abs(response["f_a_from_d"].values)[[0, -1]]
    assert (split.left_below, split.left_above) == pytest.approx(tuple(size), rel=0.05)
    below, above = np.abs(response["S"].values)[[1, 2]]
    assert below < 1.0 < above
    assert split.varies_n == pytest.approx(2e-3, rel=0.01)
    assert split.force_varies_n == pytest.approx(float(run.f_a.values[settled].std()))


def test_the_bands_add_up_to_the_whole():
    run = disturbed(20.0, 1000.0)
    everything = np.ones(run.sizes["time"], bool)
    bands = by_band(run, everything, split_edges((300,), RATE_HZ))
    squares = sum(each.left_n**2 for each in bands) / sum(each.disturbance_n**2 for each in bands)
    assert squares == pytest.approx(fl.metrics(run)["disturbance_left"] ** 2, rel=1e-2)
    assert bands[0].disturbance_left == pytest.approx(bands[0].left_n / bands[0].disturbance_n)
    calm = fl.simulate(fl.feasible().evolve({"disturbance": fl.Constant()}), 1.0)
    assert all(math.isnan(each.disturbance_left) for each in by_band(calm, everything, split_edges((8,), RATE_HZ)))
    assert by_band(calm, ~everything, split_edges((8,), RATE_HZ)) == ()


def test_without_feedback_all_is_left_and_no_frequency_is_known():
    run = disturbed(20.0, **{"controller.kind": "lookup"})
    split = disturbance_split(run, np.ones(run.sizes["time"], bool))
    assert math.isnan(split.amplified_from_hz) and math.isnan(split.left_below)
    assert split.left_late == pytest.approx(1.0, abs=1e-9)


def test_what_the_start_adds_is_known():
    # At the first samples the loop has not acted yet, and d is far from its mean there.
    values_n = 0.02 * np.sin(2 * np.pi * 5.0 * TIME_S) + 0.08 * (TIME_S < 0.01)
    signals = LEVEL | {"disturbance": fl.Samples(values_n=values_n, rate_hz=RATE_HZ)}
    run = fl.simulate(fl.feasible().evolve(signals), 0.6)
    late = fl.metrics(run, run.time.values >= 0.1)["disturbance_left"]
    split = disturbance_split(run, np.ones(run.sizes["time"], bool))
    assert split.left_late == pytest.approx(late) and late < fl.metrics(run)["disturbance_left"] / 1.05


@pytest.mark.parametrize(("tones_hz", "mixed"), [((7.5,), [8.0]), ((3.0, 90.0), None)])
def test_a_tone_that_is_too_near_to_an_edge_is_found(tones_hz, mixed):
    run = disturbed(*tones_hz, duration_s=2.0, disturbance=tones(*tones_hz, size_n=0.02))
    mask = run.time.values >= 0.5
    found = list(of_bands(run, mask, by_band(run, mask, split_edges((8,), RATE_HZ))))
    assert [each.more["edges"] for each in found] == ([mixed] if mixed else [])
    assert all(each.value == pytest.approx(2.0 / 1.5, rel=1e-3) for each in found)
