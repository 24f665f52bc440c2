"""The published numbers beside ours: what is kept is what is computed, and verdicts follow from the numbers."""

from __future__ import annotations

import csv
import math

import pytest

import frictionloop as fl
from studies import kept, validation
from studies.validation import BUILT, OUTSIDE, UNREAD, WITHIN
from studies.validation_numbers import NUMBERS

with (kept.RESULTS / "validation.csv").open(newline="", encoding="utf-8") as stream:
    ROWS = {row["number"]: row for row in csv.DictReader(line for line in stream if not line.startswith("#"))}
BY_NAME = {each.number: each for each in NUMBERS}


def test_all_23_numbers_are_kept_in_their_order():
    assert list(ROWS) == list(BY_NAME)
    assert {int(name.rstrip("ab")) for name in ROWS} == set(range(1, 24))


@pytest.mark.parametrize("name", BY_NAME)
def test_the_row_that_is_kept_follows_from_its_numbers(name):
    each, row = BY_NAME[name], ROWS[name]
    ours = float(row["ours"]) if each.how else None
    assert tuple(row.values()) == validation.row(each, ours)
    inside = ours is not None and each.low <= ours <= each.high
    expected = UNREAD if ours is None else (BUILT if each.built else WITHIN) if inside else OUTSIDE
    assert row["verdict"].split(":")[0] == expected


@pytest.mark.parametrize("name", ["1a", "3b", "10", "13", "14", "18"])
def test_a_number_that_is_cheap_is_the_one_kept(name):
    assert validation.told(validation.value(BY_NAME[name])) == ROWS[name]["ours"]


def test_numbers_with_a_closed_form_have_it():
    bench = fl.bench()
    kept_ones = {name: float(row["ours"]) for name, row in ROWS.items() if BY_NAME[name].how}
    friction, z_mm = bench.friction, 1e-3 * bench.finger.slip_length_um
    left = math.exp(-friction.susceptibility_per_um2 * bench.plate.max_amplitude_um**2)
    # Half a substep, 10 us, is a phase of 0.006 at 100 Hz: 7 % of that at 80 mm/s, 2 % at 20; of their difference 10 %.
    assert kept_ones["1a"] == pytest.approx(1.0 / (2.0 * math.pi * z_mm), rel=0.1)
    assert kept_ones["10"] == pytest.approx(100.0 * (20.0 ** (friction.load_exponent - 1.0) - 1.0), abs=0.05)
    assert kept_ones["11"] == pytest.approx(friction.occlusion_s * math.log(20.0), abs=0.05)
    assert kept_ones["12"] == pytest.approx(friction.occlusion_ratio, abs=0.005)
    assert kept_ones["13"] == pytest.approx(100.0 * left, abs=0.005)
    assert kept_ones["14"] == pytest.approx(left**-friction.moist_loss, abs=0.005)


def test_a_parameter_taken_from_its_source_still_has_to_be_within_it():
    each = BY_NAME["15"]
    assert validation.verdict(55.0, each).startswith(BUILT)
    assert validation.verdict(100.0, each) == OUTSIDE
