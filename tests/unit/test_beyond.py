"""A limit observer that is beyond what it states says so, and one that is not says nothing."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.cli.advice_text import beyond_lines
from frictionloop.loop.told import Beyond, beyond

BENCH = fl.bench().evolve({"controller.kind": "limit_observer", "motion.speed_mm_s": 80.0})


def test_a_finger_as_told_is_within():
    found = beyond(fl.simulate(BENCH, 6.0))
    assert found.surprised == 0.0
    assert found.bound < 0.1
    assert beyond_lines(found) == []


def test_a_resonance_far_below_the_believed_one_surprises_it():
    """It rings there; the mean square has half a second's memory."""
    found = beyond(fl.simulate(BENCH.evolve({"sensor.resonance_hz": 100.0}), 3.0))
    assert found.surprised > 0.7
    assert "held its least gain" in beyond_lines(found)[0]


def test_a_susceptibility_beyond_the_spread_ends_at_its_bound():
    """tau is 1.6 times the model's, the spread 1.2."""
    large = {"friction.susceptibility_per_um2": 0.6, "controller.susceptibility_spread": 1.2}
    found = beyond(fl.simulate(BENCH.evolve(large), 6.0))
    assert found.bound > 0.3
    assert "controller.susceptibility_spread" in " ".join(beyond_lines(found))


def test_of_another_law_there_is_nothing_to_say():
    assert beyond(fl.simulate(fl.bench(), 0.1)) is None
    assert beyond_lines(None) == []


@pytest.mark.parametrize(("share", "told"), [(0.0049, False), (0.005, True)])
def test_what_rounds_to_nothing_is_not_told(share, told):
    assert bool(beyond_lines(Beyond(share, 0.0))) is told
