"""A search whose grid of frequencies missed a peak by a little: its gains are lowered, not refused."""

from __future__ import annotations

import re

import pytest

import frictionloop as fl
from frictionloop.design.corners import corners
from frictionloop.design.requirements import Designed, Requirements
from frictionloop.design.synthesis import held_between
from frictionloop.quantities import FrictionloopError

BENCH = fl.bench()
WANTED = Requirements(resonance_error=0.0, slip_lengths_um=(11.5,))
PI = {"controller.kind": "pi", "controller.kp": 0.03, "controller.ki": 40.0}


def limit_on_ki() -> float:
    """The factor on `PI` up to which Ms stays within 1.7 wherever it is looked at, by each loop alone."""
    at = corners(BENCH.evolve(PI), WANTED.grid(1, 1))
    return min(each.loop.gain_factor(each.limit) for each in at)


def times(factor):
    gains = {path: factor * PI[path] for path in ("controller.kp", "controller.ki")}
    return lambda system, wanted: Designed({**PI, **gains})


def test_gains_that_are_a_little_too_large_are_lowered_to_those_that_hold():
    most = limit_on_ki()
    found, at = held_between(BENCH, "pi", times(1.03 * most), WANTED)
    assert found.overrides["controller.ki"] == pytest.approx(most * PI["controller.ki"], rel=1e-3)
    assert found.overrides["controller.kp"] == pytest.approx(most * PI["controller.kp"], rel=1e-3)
    assert max(each.sensitivity_peak for each in at) == pytest.approx(1.7, rel=1e-3)


def test_gains_that_are_much_too_large_are_refused_with_the_nearest_limit_that_would_do():
    most = limit_on_ki()
    said = r"law pi: Ms \S+, 1\.7 asked, .*; --sensitivity-peak \S+ may hold$"
    with pytest.raises(FrictionloopError, match=said) as caught:
        held_between(BENCH, "pi", times(1.2 * most), WANTED)
    assert caught.value.code == "NO-CONTROLLER"
    peak = float(re.search(r"--sensitivity-peak (\S+) may", str(caught.value))[1])
    assert held_between(BENCH, "pi", times(1.2 * most), Requirements(peak, 0.0, slip_lengths_um=(11.5,)))
    with pytest.raises(FrictionloopError, match=r"; --sensitivity-peak \S+ may hold, or --law pi$"):
        held_between(BENCH, "notch_pi", times(1.2 * most), WANTED)
