"""Gains that hold with sensor, delay and gain at the ends of their intervals at once."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.design.corners import band_of, corners
from frictionloop.design.leaning import Lean, leaning
from frictionloop.design.synthesis import design_controller
from frictionloop.design.wanted import Wanted

BENCH = fl.bench()
LEAN = Lean(sensor_error=0.2, delay_error=0.2, gain_error=0.1)


def test_a_leaning_loop_is_that_of_the_other_bench():
    points = band_of(BENCH.evolve({"controller.kind": "pi"}))
    slow = leaning(points, LEAN)[len(points)]
    changed = {"sensor.cutoff_hz": 0.8 * BENCH.sensor.cutoff_hz, "controller.delay_s": 1.2 * BENCH.controller.delay_s}
    other = band_of(BENCH.evolve({"controller.kind": "pi"} | changed))[0]
    for hertz in (5.0, 100.0, 700.0):
        mine, theirs = (loop.plant.response(hertz)[0, 1, 0] for loop in (slow, other))
        assert mine == pytest.approx(1.1 * theirs, rel=1e-9)
    assert leaning(points, Lean()) == points


@pytest.mark.slow
def test_gains_hold_at_the_ends():
    plain, careful = (
        design_controller(BENCH, "pi", Wanted(resonance_error=0.01, lean=lean)) for lean in (Lean(), LEAN)
    )
    limits = Wanted(resonance_error=0.01).limits
    worst = [
        max(each.excess for each in corners(BENCH.evolve(found.overrides), limits, lean=LEAN))
        for found in (plain, careful)
    ]
    assert worst[0] > 1.01 and worst[1] <= 1.0011
    assert careful.overrides["controller.ki"] < plain.overrides["controller.ki"]


def test_a_share_that_is_none_is_refused():
    with pytest.raises(fl.FrictionloopError, match=r"delay_error = 0.7: must be from 0 to 0.5"):
        Wanted(lean=Lean(delay_error=0.7))
