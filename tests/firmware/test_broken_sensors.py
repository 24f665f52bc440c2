"""A sensor that breaks while the finger slides and the plate is driven is a fault, and the plate is down soon after."""

from __future__ import annotations

from statistics import median

import pytest
from broken_sensors import FAILURES, TICK_HZ, bench, notice, slid
from whole_sensors import FIRST, FRESH, OTHER

DOWN = 15 * TICK_HZ // 1000
"""From the fault to a plate at rest: the ramp takes 10 ms."""
MANY = 100
HARD = {"floating": 0.9, "mains, 50 Hz": 0.9, "mains, 60 Hz": 0.9, "mains, strong": 0.95}
"""Least share of fingers on which a failure is told in time; of the others it is all of them.

A law that answers a hum bends it, or rings with it.
"""


@pytest.mark.parametrize("law", ["notch_pi", "limit_observer"])
@pytest.mark.parametrize("name", FAILURES)
def test_a_broken_sensor_is_told_and_the_plate_comes_to_rest(name: str, law: str):
    failure = FAILURES[name]
    noticed = notice(bench(law), failure.tells)
    assert noticed is not None, "nothing was told"
    assert noticed.fault in failure.faults
    assert noticed.ticks <= failure.ticks
    assert noticed.down <= DOWN


@pytest.mark.soak
@pytest.mark.parametrize("name", FAILURES)
def test_it_is_told_of_many_fingers(name: str, record_property):
    check(name, FIRST, record_property)


@pytest.mark.soak
@pytest.mark.parametrize("name", HARD)
def test_a_hum_is_told_of_other_fingers(name: str, record_property):
    check(name, OTHER, record_property)


@pytest.mark.soak
@pytest.mark.parametrize("name", HARD)
def test_a_hum_is_told_of_fresh_fingers(name: str, record_property):
    check(name, FRESH, record_property)


def check(name: str, seed: int, record_property):
    """Break a sensor under fingers of a population, and record how soon a fault tells it and the plate is at rest."""
    failure, noticed = FAILURES[name], []
    for number in range(MANY):
        noticed.append(notice(slid(number, seed), failure.tells, seed=number))
    told = [each for each in noticed if each is not None]
    ms, in_time = 1e3 / TICK_HZ, sum(each.ticks <= failure.ticks for each in told)
    record_property("faults", ", ".join(sorted({each.fault for each in told})))
    record_property("found, of 100", len(told))
    record_property("in time, of 100", in_time)
    record_property("found after, median, ms", round(ms * median(each.ticks for each in told), 1))
    record_property("plate at rest after, worst, ms", round(ms * max(each.ticks + each.down for each in told), 1))
    assert {each.fault for each in told} <= set(failure.faults)
    assert max(each.down for each in told) <= DOWN
    assert in_time >= HARD.get(name, 1.0) * MANY
