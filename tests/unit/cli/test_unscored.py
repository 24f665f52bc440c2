"""What no metric says of a run: a force beyond the sensor's range, and strokes too short for feedback."""

from __future__ import annotations

import frictionloop as fl
from frictionloop.cli.unscored import beyond_sensor, lines


def test_a_force_beyond_the_sensor_is_told():
    run = fl.simulate(
        fl.bench().evolve({"sensor.range_n": 1.0, "motion.load_n": 1.0, "controller.kind": "lookup"}), 2.0
    )
    share = float((run.f_a.values > 1.0).mean())
    assert 0.0 < share < 1.0
    assert f"above the range for {share:.2%} of the time: the sensor's range ends at" in beyond_sensor(run, 0.0)
    assert beyond_sensor(fl.simulate(fl.feasible(), 0.2), 0.0) == ""
    assert lines(fl.simulate(fl.feasible(), 0.2), 0.0) == []
