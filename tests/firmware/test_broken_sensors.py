"""A sensor that breaks while the finger slides and the plate is driven is a fault, and the plate is down soon after."""

from __future__ import annotations

from statistics import median

import pytest
from broken_sensors import FAILURES, FROM_THE_START, TICK_HZ, UNTOLD, bench, notice, slid

DOWN = 15 * TICK_HZ // 1000
"""From the fault to a plate at rest: the ramp takes 10 ms."""
MANY, FEW = 100, 10
HARD = {"floating": 0.9, "mains, 50 Hz": 0.9, "mains, 60 Hz": 0.9, "mains, strong": 0.95, "half the gain": 0.9}
"""Least share of fingers on which a failure is told in time; of the others it is all of them.

A law that answers a hum bends it, or rings with it; half of a small force is within what springs can do.
"""


@pytest.mark.parametrize("law", ["notch_pi", "limit_observer"])
@pytest.mark.parametrize("name", FAILURES)
def test_a_broken_sensor_is_told_and_the_plate_comes_to_rest(name: str, law: str):
    failure = FAILURES[name]
    noticed = notice(bench(law), failure.tells)
    assert noticed.fault in failure.faults
    assert noticed.ticks <= failure.ticks
    assert noticed.down <= DOWN


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", FAILURES)
def test_it_is_told_of_many_fingers(name: str, record_property):
    failure, ms = FAILURES[name], 1e3 / TICK_HZ
    noticed = [notice(slid(number), failure.tells, seed=number) for number in range(MANY)]
    told = [each for each in noticed if each.fault]
    in_time = sum(each.ticks <= failure.ticks for each in told)
    record_property("faults", ", ".join(sorted({each.fault for each in told})))
    record_property("found, of 100", len(told))
    record_property("in time, of 100", in_time)
    record_property("found after, median, ms", round(ms * median(each.ticks for each in told), 1))
    record_property("plate at rest after, worst, ms", round(ms * max(each.ticks + each.down for each in told), 1))
    assert {each.fault for each in told} <= set(failure.faults)
    assert max(each.down for each in told) <= DOWN
    assert in_time >= HARD.get(name, 1.0) * MANY


@pytest.mark.soak
@pytest.mark.parametrize("name", UNTOLD)
def test_what_may_not_be_told(name: str, record_property):
    _record(record_property, [notice(slid(number), UNTOLD[name], seed=number) for number in range(FEW)])


@pytest.mark.soak
@pytest.mark.parametrize("name", FROM_THE_START)
def test_what_was_broken_before_the_loop_was_closed(name: str, record_property):
    tells = FROM_THE_START[name]
    noticed = [notice(slid(number), tells, seed=number, lead_s=0.0, most=TICK_HZ) for number in range(FEW)]
    _record(record_property, noticed)
    if name == "open input":
        assert all(each.fault == "sensor_contrary" for each in noticed)


def _record(record_property, noticed):
    """Keep how many tell a fault, and what the plate does to the others."""
    left = [each for each in noticed if not each.fault]
    record_property("faults", ", ".join(sorted({each.fault for each in noticed} - {""})))
    record_property("found, of 10", FEW - len(left))
    for name, values in (
        ("force over set-point", [each.force_share for each in left]),
        ("amplitude, um", [each.amplitude_um for each in left]),
    ):
        record_property(name, [round(float(end(values)), 2) for end in (min, max)] if left else [])
    assert all(each.highest_um <= 2.5 for each in noticed)
