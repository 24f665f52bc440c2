"""Contacts, speeds and loads that a controller is held over."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.design.controller_check import check
from frictionloop.design.corners import corners
from frictionloop.design.operating_grid import ITSELF, OperatingGrid
from frictionloop.design.requirements import Requirements
from frictionloop.design.synthesis import synthesised

BENCH = fl.bench()
WEAK = {"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 2.0}


def at(systems):
    return [(each.finger.slip_length_um, each.motion.speed_mm_s, each.motion.load_n) for each in systems]


def test_every_combination_the_longest_first():
    assert ITSELF.systems(BENCH) == [BENCH]
    found = OperatingGrid((0.0, 11.5), (20.0, 60.0), (0.4,)).systems(BENCH)
    assert at(found) == [(length_um, v, 0.4) for length_um in (11.5, 0.0) for v in (20.0, 60.0)]
    longer, none = (BENCH.evolve({"finger.slip_length_um": z}) for z in (30.0, 0.0))
    assert OperatingGrid(None).lengths_of(longer) == (30.0, 0.0) and OperatingGrid(None).lengths_of(none) == (11.5, 0.0)
    assert OperatingGrid().lengths_of(longer) == (30.0,) and OperatingGrid((5.0, 5.0)).lengths_of(longer) == (5.0,)
    rigid = BENCH.evolve({"finger": {"kind": "rigid"}})
    assert OperatingGrid((0.0, 11.5)).systems(rigid) == [rigid]


@pytest.mark.parametrize("over", [OperatingGrid(speeds_mm_s=(20.0,)), OperatingGrid(loads_n=(0.4,))])
def test_a_finger_that_does_not_stroke_has_neither_speeds_nor_loads(over):
    with pytest.raises(fl.FrictionloopError, match=r'motion\.kind = ".*" has none; needs "strokes"'):
        over.systems(fl.feasible())


@pytest.mark.slow
def test_a_design_for_loads_and_contacts_holds_its_limits_between_them():
    wanted = Requirements(loads_n=(0.4, 0.8))
    limited = ITSELF._replace(limits=wanted.limits)
    made = BENCH.evolve(dict(synthesised(BENCH, "pi", wanted)[0].overrides))
    own = BENCH.evolve(dict(synthesised(BENCH, "pi", Requirements())[0].overrides))
    for length_um in (11.5, 0.0):
        for load in (0.4, 0.5, 0.65, 0.8):
            there = corners(made.evolve({"finger.slip_length_um": length_um, "motion.load_n": load}), limited)
            assert max(each.excess for each in there) <= 1.002
        assert max(each.excess for each in corners(own.evolve({"finger.slip_length_um": length_um}), limited)) <= 1.002
    heavy = corners(own.evolve({"finger.slip_length_um": 0.0, "motion.load_n": 0.8}), limited)
    assert max(each.excess for each in heavy) > 1.05  # which a design for 0.5 N does not hold


def test_a_load_at_which_no_force_can_be_had_is_refused():
    faint = BENCH.evolve({**WEAK, "plate.max_amplitude_um": 1.0, "controller.model.max_amplitude_um": 1.0})
    with pytest.raises(fl.FrictionloopError, match=r"in reach at motion\.load_n = 1\.26"):
        check(faint, Requirements(loads_n=(0.4, 4.0)))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"loads_n": (0.0, 1.0)}, "loads_n = .*: must be above 0"),
        ({"slip_lengths_um": (-1.0,)}, "slip_lengths_um = .*: must be from 0 to 1000"),
    ],
)
def test_what_is_no_load_or_contact_is_refused(given, said):
    with pytest.raises(fl.FrictionloopError, match=said):
        Requirements(**given)
