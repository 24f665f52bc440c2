"""A design says where it does not hold that it was not asked to look at."""

from __future__ import annotations

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH

import frictionloop as fl
from frictionloop.analysis import linearise, operating_band
from frictionloop.design.controller_findings import of_places
from frictionloop.design.controller_synthesis import synthesised
from frictionloop.design.grid_corners import corners, elsewhere, strokes_of
from frictionloop.design.operating_grid import ITSELF, OperatingGrid
from frictionloop.design.requirements import Requirements

LIMITED = ITSELF._replace(limits=Requirements().limits)
NOWHERE = (), ()
OTHERS = [(11.5, 80.0), (0.0, 10.0), (0.0, 20.0), (0.0, 80.0)]


def where(found, how):
    return tuple(place for place in found if place.how == how)


def at(found):
    return [(place.slip_length_um, *place.speeds_mm_s) for place in found]


def test_gains_for_a_long_contact_that_are_unstable_without_a_length_are_a_warning():
    gains = fl.retune(fl.bench().evolve({"finger.slip_length_um": 30.0})).overrides
    found, _ = elsewhere(fl.bench().evolve(gains), LIMITED)
    slider = fl.bench().evolve({**gains, "finger.slip_length_um": 0.0})
    assert not all(each.margins().stable for each in operating_band(slider, occluded=(0.0, 1.0)))
    assert at(where(found, "unstable"))[-3:] == OTHERS[1:]
    told = [each for each in of_places(found, 0) if each.code == "LOOP-UNSTABLE"]
    assert {each.severity for each in told} == {"warning"} and all(each.value > 100.0 for each in told)
    assert [(each.where.slip_length_um, each.where.speed_mm_s) for each in told][-1] == (0.0, (10.0, 20.0, 80.0))
    assert {each.severity for each in of_places(found, len(found))} == {"error"}


@pytest.mark.slow
def test_a_notch_for_one_speed_is_told_not_to_hold_at_half_of_it():
    """A slower finger lags by a longer time over the same length."""
    found, unseen = elsewhere(fl.bench().evolve(DESIGNED_NOTCH), LIMITED)
    assert (where(found, "unstable"), where(found, "near"), unseen) == ((), (), ())
    assert at(where(found, "beyond")) == [(11.5, 10.0)] and at(where(found, "within")) == OTHERS
    (worst,) = where(found, "beyond")
    (told,) = of_places(found, 0)
    assert (told.code, told.value) == ("MS-BEYOND", worst.worst.sensitivity_peak)
    slow = {"motion.speed_mm_s": 10.0, "sensor.resonance_hz": (1 + worst.worst.off) * 145.0}
    told, slow_bench = worst.worst.sensitivity_peak, fl.bench().evolve({**DESIGNED_NOTCH, **slow})
    assert told > 2.6 and told >= 0.99 * linearise(slow_bench, force_n=0.5).margins().sensitivity_peak


@pytest.mark.slow
def test_little_gain_holds_everywhere():
    weak = {"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 7.0}
    found, unseen = elsewhere(fl.bench().evolve(weak), LIMITED)
    assert where(found, "within") == found
    assert at(found) == [(11.5, 10.0), *OTHERS]
    assert [*of_places(found, 0)] == [] and unseen == ()


def test_where_nothing_else_is_there_is_nothing_to_say():
    assert elsewhere(fl.bench().evolve({"finger": {"kind": "rigid"}}), LIMITED) == NOWHERE


def test_strokes_are_both_contacts_at_three_speeds_its_own_first():
    found = [tuple(changes.values()) for changes in strokes_of(fl.bench())]
    assert found == [(11.5, 10.0), (11.5, 20.0), *OTHERS]
    slow = fl.bench().evolve({"touch.load.least_speed_mm_s": 11.0})
    assert min(changes["motion.speed_mm_s"] for changes in strokes_of(slow)) == 20.0


@pytest.mark.slow
def test_a_stroke_with_no_room_to_turn_at_a_speed_is_looked_at_as_a_long_one_is():
    """A linear loop slides and does not turn, so its stroke and its reversal move no margin."""
    weak = {"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 7.0, "motion.speed_mm_s": 50.0}
    short, long = (elsewhere(fl.bench().evolve({**weak, "motion.stroke_mm": each}), LIMITED) for each in (10.0, 60.0))
    assert short[1] == long[1] == ()
    peaks = [[place.worst.sensitivity_peak for place in places] for places, _ in (short, long)]
    np.testing.assert_allclose(*peaks, rtol=1e-12)


@pytest.mark.slow
def test_gains_for_a_fast_stroke_say_that_they_do_not_hold_on_a_slower_one():
    fast = fl.bench().evolve({**DESIGNED_NOTCH, "motion.speed_mm_s": 40.0})
    assert (11.5, 20.0) in not_held(fast)
    assert (11.5, 20.0) not in not_held(fast, (20.0, 40.0))


def not_held(system, speeds_mm_s=()):
    found, _ = elsewhere(system, OperatingGrid(speeds_mm_s=speeds_mm_s, limits={0.0: 1.0, 0.1: 1.0}))
    return at(each for each in found if each.how != "within")


@pytest.mark.slow
def test_a_design_for_a_range_of_speeds_holds_its_limits_between_them():
    wanted = Requirements(speeds_mm_s=(10.0, 20.0), slip_lengths_um=())
    found = synthesised(fl.bench(), "pi", wanted)[0]
    made = fl.bench().evolve(dict(found.overrides))
    for speed in (10.0, 11.5, 13.0, 16.0, 18.0, 20.0):
        there = corners(made.evolve({"motion.speed_mm_s": speed}), LIMITED)
        assert max(each.excess for each in there) <= 1.002
    assert found.overrides["controller.ki"] < fl.retune(fl.bench(), 1.7).ki


@pytest.mark.slow
def test_with_a_range_the_other_contact_is_looked_at_at_its_ends():
    weak = {"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 2.0}
    found, _ = elsewhere(fl.bench().evolve(weak), LIMITED._replace(speeds_mm_s=(15.0, 60.0)))
    assert {(0.0, speed) for speed in (15.0, 20.0, 60.0)} <= set(at(where(found, "within")))
    assert not {(11.5, 15.0), (11.5, 20.0), (11.5, 60.0)} & set(at(found))
