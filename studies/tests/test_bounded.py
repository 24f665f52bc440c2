"""Fingers within reach of the forces of a comparison while their load moves."""

from __future__ import annotations

import numpy as np

import frictionloop as fl
from frictionloop.design.comparison import protocol
from studies.bounded import within_reach


def test_fingers_within_reach_can_be_given_the_forces_while_their_load_moves():
    people = fl.fingers(60, 5)
    some = within_reach(fl.bench(), people, 20.0)
    able = protocol.able(fl.bench(), people, 20.0)
    assert 0 < some.sum() < able.sum()
    assert not np.any(some & ~able)
    still = [{**each, "motion.load_drift": 0.0, "motion.tremor_n": 0.0} for each in people]
    np.testing.assert_array_equal(within_reach(fl.bench(), type(people)(still), 20.0), able)


def test_fingers_within_reach_are_short_a_twentieth_of_the_time_at_most():
    """Without vibration friction is the highest there is, with all of it the lowest: of a slider, the limit itself."""
    people, at = fl.fingers(60, 5), protocol.Condition(20.0, 0.0, "hold 0.6")
    able, near = (choose(fl.bench(), people, 20.0) for choose in (protocol.able, within_reach))
    smooth = {"friction.roughness_rms": 0.0, "friction.speed_slope": 0.0, "friction.occlusion_ratio": 1.0}
    still = {**protocol.overrides_of(at), "motion.load_drift_s": 1.0, "controller.kind": "lookup"}

    def share(finger, level_n, out):
        system = fl.bench().evolve({**still, **finger, **smooth, "setpoint": fl.Constant(offset_n=level_n)})
        runs = [fl.simulate(system, 4.0, seed).isel(time=slice(5000, None)) for seed in (1, 2, 3, 4)]
        return np.mean([out(run["f_a"].values[run["scored"].values]).mean() for run in runs])

    highest, lowest = (2.4, lambda force: force < protocol.HIGH_N), (0.02, lambda force: force > protocol.LOW_N)
    short = np.array([max(share(people[i], *highest), share(people[i], *lowest)) for i in np.flatnonzero(able)])
    assert np.max(short[near[able]]) < 0.05
    assert np.mean(short[~near[able]] > 0.05) > 0.75
