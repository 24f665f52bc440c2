"""What no metric says of a run: the force where the finger turns round, and a force beyond the sensor's range."""

from __future__ import annotations

import numpy as np

import frictionloop as fl
from frictionloop.cli.unscored import at_reversals, beyond_sensor, lines


def test_the_force_at_reversals_is_told_with_its_time_and_how_long_it_lasts():
    run = fl.simulate(fl.bench().evolve({"controller.kp": 0.03, "controller.ki": 20.0}), 10.0)
    scored, above = run.scored.values, (run.f_a - run.f_r).values
    error_n = fl.rms_error(run)
    assert at_reversals(run.assign(f_a=run.f_r), 0.0, error_n) == ""
    spiked = run.f_r.values.copy()
    first = int(np.flatnonzero(~scored & (run.time.values > 1.0))[3])
    assert not scored[first : first + 100].any()
    spiked[first : first + 100] += 10 * error_n
    spiked[first + 50] += error_n
    said = at_reversals(run.assign(f_a=("time", spiked)), 0.0, error_n)
    assert f"the force goes up to {spiked[first + 50]:.3g} N (at {run.time.values[first + 50]:.4g} s" in said
    assert "above the set-point 1 time, for up to 20 ms" in said
    assert at_reversals(run.assign(f_a=("time", spiked)), run.time.values[first + 100], error_n) == ""
    own = at_reversals(run, 0.0, error_n)
    assert (own != "") is bool((above[~scored & (run["load"].values > 0.05)] > 3 * error_n).any())


def test_a_force_beyond_the_sensor_is_told():
    run = fl.simulate(
        fl.bench().evolve({"sensor.range_n": 1.0, "motion.load_n": 1.0, "controller.kind": "lookup"}), 2.0
    )
    share = float((run.f_a.values > 1.0).mean())
    assert 0.0 < share < 1.0
    assert f"above the range for {share:.2%} of the time: the sensor's range ends at" in beyond_sensor(run, 0.0)
    assert beyond_sensor(fl.simulate(fl.feasible(), 0.2), 0.0) == ""
    assert lines(fl.simulate(fl.feasible(), 0.2), 0.0, 0.01) == []
