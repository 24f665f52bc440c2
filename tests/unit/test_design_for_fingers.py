"""Gains lowered for other fingers, and the loops that a grid picks as the worst."""

from __future__ import annotations

import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli.check_fingers import _of_others, not_lowered
from frictionloop.design.corners import corners
from frictionloop.design.for_fingers import for_fingers
from frictionloop.design.least_gain import laws_on
from frictionloop.design.on_fingers import check_fingers
from frictionloop.design.plants import Plants
from frictionloop.design.requirements import Requirements
from frictionloop.design.synthesis import design_controller
from frictionloop.design.worst_margins import worst_margins

BENCH, ON_DAHL = fl.bench(), Requirements(slip_lengths_um=(11.5,))


@pytest.fixture(scope="module")
def designed():
    return design_controller(BENCH, "pi", ON_DAHL)


@pytest.fixture(scope="module")
def found(designed):
    return check_fingers(BENCH.evolve(designed.overrides), fl.fingers(6, 0), ON_DAHL, progress=False)


@pytest.mark.slow
def test_lowered_gains_hold_on_each_finger_and_on_the_worst_just_so(designed, found):
    made = for_fingers(BENCH, designed, found, ON_DAHL)
    assert made.factor == float(found["gain_factor"].min()) < 1.0 and made.least_ki is None
    again = check_fingers(BENCH.evolve(made.designed.overrides), fl.fingers(6, 0), ON_DAHL, progress=False)
    assert again["holds"].all() and float(again["gain_factor"].min()) == pytest.approx(1.0, rel=1e-3)
    assert {each.sensitivity_peak for each in made.designed.corners} != {
        each.sensitivity_peak for each in designed.corners
    }


@pytest.mark.slow
def test_gains_that_hold_everywhere_stay(designed, found):
    easy = found.assign(gain_factor=found["gain_factor"] + 1.0)
    assert for_fingers(BENCH, designed, easy, ON_DAHL).designed is designed


def test_gains_too_small_to_be_of_use_are_not_lowered_to(designed, found):
    hard = found.assign(gain_factor=("finger", np.array([0.8, 0.01, np.nan, 1.0, 1.0, 1.0])))
    made = for_fingers(BENCH, designed, hard, ON_DAHL)
    assert made.designed is designed and made.factor == 1.0 and made.wanting
    assert made.least_ki == pytest.approx(0.01 * designed.overrides["controller.ki"], rel=1e-4)
    assert not_lowered(made)[0][1].startswith("the gains were not lowered for all")


@pytest.mark.slow  # margins of each of 240 loops
def test_the_worst_margins_of_many_loops_are_those_of_a_look_at_each(designed):
    many = Requirements(speeds_mm_s=(10.0, 40.0), loads_n=(0.4, 0.8))
    at = corners(BENCH.evolve(designed.overrides), many.limits, many.over(3, 2))
    exact, loops = {id(each): each.loop.margins() for each in at}, [each.loop for each in at]
    plants = Plants.of(loops, fine=False)
    for each, returned in zip(at, 1.0 + laws_on(plants.frequency_hz, loops) * plants.responses, strict=True):
        # The nearest of the grid lies half a chord beside the nearest point to -1 at most.
        k, chords = np.abs(returned).argmin(), np.abs(np.diff(returned))
        least, step = 1.0 / exact[id(each)].sensitivity_peak, chords[max(k - 1, 0) : k + 1].max()
        assert least * (1 - 1e-6) <= 1.0 / each.sensitivity_peak <= 1.001 * np.hypot(least, step / 2)
    for (off, occluded), picked in worst_margins(at).items():
        here = [exact[id(each)] for each in at if (each.off, each.loop.elements.occluded) == (off, occluded)]
        for least in (
            lambda m: abs(np.log(m.gain_margin)), lambda m: abs(m.phase_margin_deg), lambda m: m.delay_margin_s,
            lambda m: 1.0 / m.sensitivity_peak,
        ):  # fmt: skip
            assert min(map(least, picked)) == pytest.approx(min(map(least, here)), rel=0.01)
        worst = max(each.sensitivity_peak for each in at if (each.off, each.loop.elements.occluded) == (off, occluded))
        assert worst == pytest.approx(max(each.sensitivity_peak for each in here), rel=1e-6)


def test_what_many_fingers_tell_of_others_is_that_of_draws_at_random():
    """Of the worst of 20 uniform numbers, how many others are worse: on average, and in all but 5 % of the draws."""
    beyond = 1.0 - np.random.default_rng(0).uniform(size=(200_000, 20)).max(axis=1)
    (_, said), (_, command) = _of_others(20, " --speeds 20,40 --fingers 100 --fingers-seed 1")
    expected, most = re.search(r"1 in (\d+) is to be expected beyond the limits, and up to (\d+)% may", said).groups()
    assert beyond.mean() == pytest.approx(1.0 / int(expected), rel=0.01)
    assert np.quantile(beyond, 0.95) == pytest.approx(int(most) / 100.0, abs=0.006)
    assert "design check FILE --speeds 20,40 --fingers 100 --fingers-seed 1` looks at others" in command
