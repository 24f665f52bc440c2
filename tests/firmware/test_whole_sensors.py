"""Whole sensors raise no fault: a hundred hours of fingers, of all laws, set-points, speeds and contacts."""

from __future__ import annotations

import secrets
from collections.abc import Iterable
from datetime import date

import numpy as np
import pytest
from whole_sensors import EACH_S, FINGERS, FIRST, TICK_HZ, Raised, Told, raised, slid, told

from frictionloop.firmware.parameter_words import firmware_words

OVERLOADS = ("force_range", "sensor_saturated")
"""Faults of a force that is larger than the sensor can tell: what they say is true of some fingers here."""
HOURS = 100
LIMIT_COUNTS = round(0.96 * 2**15)
RINGS = TICK_HZ // 10


def is_overloaded(readings: Told, alarm: Raised) -> bool:
    """Return whether the force was too large for the sensor a moment before, or its springs ring through its range."""
    before = readings.samples[max(alarm.tick - RINGS, 0) : alarm.tick + 1, 0]
    return alarm.name in OVERLOADS or bool(np.abs(before).max() >= LIMIT_COUNTS)


def false_alarms(fingers: Iterable[int], seed: int = FIRST, duration_s: float = EACH_S) -> list[Raised]:
    """Return the faults that are none, of some fingers of a population for a time each."""
    found = []
    for finger in fingers:
        system = slid(finger, seed)
        readings = told(system, finger, duration_s)
        alarms = raised(readings, firmware_words(system), finger)
        found += [alarm for alarm in alarms if not is_overloaded(readings, alarm)]
    return found


@pytest.mark.slow
def test_some_fingers_raise_no_fault():
    assert false_alarms(range(0, FINGERS, 101)) == []


@pytest.mark.parametrize(("seed", "finger"), [(2768394191, 41), (3806172175, 91)])
def test_fingers_that_once_raised_one(seed, finger):
    """A plate that was driven while the board was taken to be idle; a skin that pulls by more than the sensor tells."""
    assert false_alarms([finger], seed) == []


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("hour", range(HOURS))
def test_an_hour_of_a_hundred_fingers_raises_no_fault(hour: int, is_stored: bool, record_property):
    """Of a seed that is drawn now, the limits being as they are. An hour that is stored of this code is not run."""
    if is_stored:
        pytest.skip("stored")
    seed, hundred = secrets.randbits(32), round(3600 / EACH_S)
    found = false_alarms(range(hundred), seed)
    record_property("date", date.today().isoformat())
    record_property("seed", seed)
    record_property("false alarms", len(found))
    assert found == []
