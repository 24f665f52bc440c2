"""A sensor that breaks while the finger slides and the plate is driven is a fault, and the plate is down soon after."""

from __future__ import annotations

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
def test_it_is_told_of_many_fingers(name: str):
    check(name, FIRST)


@pytest.mark.soak
@pytest.mark.parametrize("name", HARD)
def test_a_hum_is_told_of_other_fingers(name: str):
    check(name, OTHER)


@pytest.mark.soak
@pytest.mark.parametrize("name", HARD)
def test_a_hum_is_told_of_fresh_fingers(name: str):
    check(name, FRESH)


def check(name: str, seed: int):
    """Break a sensor under fingers of a population."""
    failure, noticed = FAILURES[name], []
    for number in range(MANY):
        noticed.append(notice(slid(number, seed), failure.tells, seed=number))
    told = [each for each in noticed if each is not None]
    assert {each.fault for each in told} <= set(failure.faults)
    assert max(each.down for each in told) <= DOWN
    in_time = sum(each.ticks <= failure.ticks for each in told)
    assert in_time >= HARD.get(name, 1.0) * MANY
