"""What a loop leaves of a disturbance by bands of frequency."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.band_split import by_band, split_edges

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
