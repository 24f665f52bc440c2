"""A sensor that breaks while the finger slides and the plate is driven is a fault, and the plate is down soon after."""

from __future__ import annotations

import pytest
from broken_sensors import FAILURES, TICK_HZ, notice

import frictionloop as fl

DOWN = 15 * TICK_HZ // 1000
"""From the fault to a plate at rest: the ramp takes 10 ms."""


def bench(kind: str) -> fl.System:
    """Return the bench with a law's own gains, at a force that drives the plate, from mid-stroke."""
    plain = fl.bench().model_dump()
    plain["controller"] = {"kind": kind, "delay_s": 200e-6, "model": plain["controller"]["model"]}
    plain["setpoint"] = {"kind": "constant", "offset_n": 0.5}
    plain["motion"]["start"] = 0.1
    return fl.System.model_validate(plain)


@pytest.mark.parametrize("law", ["notch_pi", "observer"])
@pytest.mark.parametrize("name", FAILURES)
def test_a_broken_sensor_is_told_and_the_plate_comes_to_rest(name: str, law: str):
    failure = FAILURES[name]
    noticed = notice(bench(law), failure.tells)
    assert noticed is not None, "nothing was told"
    assert noticed.fault in failure.faults
    assert noticed.ticks <= failure.ticks
    assert noticed.down <= DOWN
