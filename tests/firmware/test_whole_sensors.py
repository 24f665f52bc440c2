"""Whole sensors raise no fault: ten hours of a thousand fingers, of all laws, set-points, speeds and contacts."""

from __future__ import annotations

import numpy as np
import pytest
from whole_sensors import EACH_S, FINGERS, FIRST, FRESH, OTHER, TICK_HZ, Raised, Told, raised, slid, told

from frictionloop.firmware.parameter_words import firmware_words

OVERLOADS = ("force_range", "sensor_saturated")
"""Faults of a force that is larger than the sensor can tell: what they say is true of some fingers here."""
OTHER_S = 3.6
"""Seconds of each finger of the other population."""
LIMIT_COUNTS = round(0.96 * 2**15)
RINGS = TICK_HZ // 10


def is_overloaded(readings: Told, alarm: Raised) -> bool:
    """Return whether the force was too large for the sensor a moment before, or its springs ring through its range."""
    before = readings.samples[max(alarm.tick - RINGS, 0) : alarm.tick + 1, 0]
    return alarm.name in OVERLOADS or bool(np.abs(before).max() >= LIMIT_COUNTS)


def false_alarms(fingers: range, population: int = FIRST, duration_s: float = EACH_S) -> list[Raised]:
    """Return the faults that are none, of some fingers for a time each."""
    found = []
    for finger in fingers:
        system = slid(finger, population)
        readings = told(system, finger, duration_s)
        alarms = raised(readings, firmware_words(system), finger)
        found += [alarm for alarm in alarms if not is_overloaded(readings, alarm)]
    return found


@pytest.mark.slow
def test_some_fingers_raise_no_fault():
    assert false_alarms(range(0, FINGERS, 100)) == []


@pytest.mark.soak
@pytest.mark.parametrize("hour", range(10))
def test_every_finger_raises_no_fault(hour: int, record_property):
    hundred = FINGERS // 10
    assert hundred * EACH_S == 3600
    found = false_alarms(range(hundred * hour, hundred * (hour + 1)))
    record_property("false alarms in an hour", len(found))
    assert found == []


@pytest.mark.soak
@pytest.mark.parametrize("part", range(10))
def test_other_fingers_raise_no_fault_either(part: int):
    """An hour of a thousand fingers that decided no limit by their alarms."""
    hundred = FINGERS // 10
    assert FINGERS * OTHER_S == 3600
    assert false_alarms(range(hundred * part, hundred * (part + 1)), OTHER, OTHER_S) == []


@pytest.mark.soak
@pytest.mark.parametrize("part", range(10))
def test_fresh_fingers_raise_no_fault_either(part: int):
    """An hour of a thousand fingers that decided no limit at all."""
    hundred = FINGERS // 10
    assert false_alarms(range(hundred * part, hundred * (part + 1)), FRESH, OTHER_S) == []
