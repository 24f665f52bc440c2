"""The error with turns, the force after a turn and the share of feedback: a run against the sums that a sweep keeps."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.reference_runs import TURNS
from frictionloop.loop.transients import _turns_s, reversal_metrics

HOLD = {"setpoint": fl.Constant(offset_n=0.6), "motion.speed_mm_s": 80.0, "motion.stroke_mm": 60.0}


def plain(**changes):
    names = ("position", "speed", "load", "f_a", "f_r", "sliding", "scored")
    time = np.arange(10_000) / 5000
    given = dict.fromkeys(names, time >= 0.0) | changes
    import xarray as xr

    return xr.Dataset({name: ("time", values) for name, values in given.items()}, {"time": time})


def test_a_triangle_has_the_peaks_that_it_was_given():
    t = np.arange(10_000) / 5000
    position = 0.02 * np.abs((t + 0.25) % 1.0 - 0.5)  # turns at 0.25, 0.75, 1.25 and 1.75 s; back by 1 mm 50 ms later
    force = 0.5 + 0.3 * (abs(t - 0.35) < 0.01) + 0.1 * (abs(t - 0.9) < 0.01) + 0.2 * (abs(t - 1.45) < 0.01)
    run = plain(position=position, speed=np.gradient(position, t), f_a=force, f_r=0 * t + 0.5, load=0 * t + 0.5)
    assert _turns_s(t, position) == pytest.approx([0.3, 0.8, 1.3, 1.8], abs=6e-3)
    found = reversal_metrics(run, np.ones(t.size, bool))
    assert found["turn_peak"] == pytest.approx((0.8 + 0.6 + 0.7) / 3)  # the last has less than 0.25 s left
    assert found["rms_error_turns"] == pytest.approx(np.sqrt(np.mean((force - 0.5) ** 2)))


@pytest.mark.parametrize("controller", ["notch_pi", "lookup"])
def test_a_sweep_keeps_the_numbers_of_the_run(controller):
    system = fl.bench().evolve(HOLD | {"controller.kind": controller})
    run = fl.simulate(system, 6.0, seed=2)
    grid = fl.sweep(system, [{}], 6.0, seeds=[2], metrics=list(TURNS), progress=False)
    of_run = fl.metrics(run)
    for name in TURNS:
        # The run looks for turns every 5 ms: a peak in between is the same one.
        assert grid[name].item() == pytest.approx(of_run[name], rel=1e-6), name
    assert 0.9 < of_run["feedback_share"] < 1.0
    assert of_run["rms_error_turns"] > of_run["rms_error"]


def test_a_finger_that_nobody_moves_has_no_turn():
    grid = fl.sweep(fl.feasible(), [{}], 1.0, metrics=["rms_error", *TURNS], progress=False)
    assert grid["rms_error_turns"].item() == pytest.approx(grid["rms_error"].item(), rel=1e-12)
    assert np.isnan(grid["turn_peak"].item())


def test_strokes_shorter_than_a_turn_takes_are_warned_of():
    system = fl.bench().evolve({"motion.stroke_mm": 1.25, "motion.speed_mm_s": 5.0, "motion.tremor_um": 0.0})
    with pytest.warns(fl.SignalWarning, match=r"NO-FEEDBACK: motion\.stroke_mm 1\.25 mm"):
        run = fl.simulate(system, 1.0)
    assert not run.sliding.values[run.time.values > 0.5].any()
    fl.simulate(system.evolve({"controller.kind": "lookup"}), 0.1)
