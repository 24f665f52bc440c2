"""A design says where it does not hold that it was not asked to look at."""

from __future__ import annotations

import pytest
from designed_notch import DESIGNED_NOTCH

import frictionloop as fl
from frictionloop.analysis import linearise
from frictionloop.design.elsewhere import elsewhere
from frictionloop.design.learnt import strokes_of
from frictionloop.design.wanted import Wanted

LIMITS = Wanted().limits


def test_a_notch_for_bristles_is_told_not_to_hold_on_a_slider():
    (line,) = elsewhere(fl.bench().evolve(DESIGNED_NOTCH), LIMITS)
    places = line.removeprefix("not held elsewhere, where it was not designed for: Ms gets to ").split("; ")
    assert [each.partition(" on ")[2] for each in places] == ["dahl, 80 mm/s", "slider, 20 mm/s", "slider, 80 mm/s"]
    slider = fl.bench().evolve({**DESIGNED_NOTCH, "finger.contact": "slider", "sensor.resonance_hz": 0.9 * 145.0})
    told = float(places[1].split()[0])
    assert told > 2.6 and told >= 0.99 * linearise(slider, force_n=0.5).margins().sensitivity_peak


def test_little_gain_holds_everywhere():
    weak = {"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 7.0}
    assert elsewhere(fl.bench().evolve(weak), LIMITS) == ()


@pytest.mark.parametrize("changes", [{"controller.kind": "tracker"}, {"finger": {"kind": "rigid"}}])
def test_where_nothing_else_is_there_is_nothing_to_say(changes):
    assert elsewhere(fl.bench().evolve(changes), LIMITS) == ()


def test_strokes_are_both_contacts_at_two_speeds_its_own_first():
    found = [tuple(changes.values()) for changes in strokes_of(fl.bench())]
    assert found == [("dahl", 20.0), ("dahl", 80.0), ("slider", 20.0), ("slider", 80.0)]


def test_a_stroke_too_short_for_four_times_the_speed_is_said_and_no_error():
    weak = {"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 7.0}
    short = fl.bench().evolve({**weak, "motion.stroke_mm": 10.0, "motion.speed_mm_s": 50.0})
    lines = elsewhere(short, LIMITS)
    assert [line.split(":")[0] for line in lines] == [
        f"not looked at with finger.contact = {contact}, motion.speed_mm_s = 200.0" for contact in ("dahl", "slider")
    ]
    assert all("reversal_s = 0.1 s leaves no stroke of 10 mm" in line for line in lines)
