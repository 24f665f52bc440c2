"""A device says for how much of a run readings moved its limit observer by more than it states."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli.device_run import summary
from frictionloop.control.limit_step import STATED
from frictionloop.device.recorder import state_of, surprised_of
from frictionloop.loop.told import beyond

BENCH = fl.bench().evolve(
    {
        "motion.speed_mm_s": 80.0,
        "controller.kind": "limit_observer",
        "controller.spring_noise": 0.5587,
        "controller.model.resonance_hz": 132.6,
        "controller.model.resonance_q": 13.69,
        "controller.model.sensor_hz": 553.0,
    }
)


def surprised(system: fl.System) -> tuple[float, float]:
    with fl.connect("sim:", system) as device:
        run = device.run(system.setpoint, 4.0)
    along = beyond(run)
    assert along is not None
    return summary(run)["surprised"], along.surprised


@pytest.mark.slow
def test_a_resonance_a_fifth_lower_than_told_surprises_and_the_one_told_does_not():
    assert surprised(BENCH) == (0.0, 0.0)
    told, along = surprised(BENCH.evolve({"sensor.resonance_hz": 116.0}))
    assert told > 0.01
    assert told == pytest.approx(along, abs=0.05)


def test_the_bit_is_beside_the_fault_and_the_state():
    flags = np.array([0b1_0000_1001, 0b1111_1001], np.int16)
    assert surprised_of(flags).tolist() == [True, False]
    assert state_of(flags).tolist() == [2, 2]
    assert STATED == 0.1  # FL_MOST_MISFIT of firmware/core/laws.h is its square
