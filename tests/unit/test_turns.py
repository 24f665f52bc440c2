"""Samples near a turn: a triangle in closed form, and the simulator's own rule about its strokes."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device.counted import away_from_turns


def test_a_triangle_is_left_out_at_its_corners():
    position = np.concatenate([np.arange(0.0, 10.0, 0.1), np.arange(10.0, 0.0, -0.1), np.arange(0.0, 10.0, 0.1)])
    speed = np.repeat([1.0, -1.0, 1.0], 100)
    away = away_from_turns(position, speed, 1.95)
    expected = np.ones(300, bool)
    expected[81:120] = expected[181:220] = False  # 1.9 on both sides of 10 and of 0; the ends of the run are no turns
    assert np.array_equal(away, expected)


def test_rest_and_lost_samples_are_no_turns():
    position = np.linspace(0.0, 1.0, 50)
    speed = np.ones(50)
    speed[10:20], speed[30:35], position[30:35] = 0.0, np.nan, np.nan
    assert away_from_turns(position, speed, 5.0).all()
    assert away_from_turns(position, np.zeros(50), 5.0).all()


@pytest.mark.parametrize("speed_mm_s", [20.0, 50.0])
def test_what_is_left_out_is_what_the_simulator_does_not_score(speed_mm_s):
    system = fl.bench().evolve({"motion.speed_mm_s": speed_mm_s})
    run = fl.simulate(system, duration_s=13.0)
    away = away_from_turns(
        run.position.values, run.speed.values, 2.0 * system.motion.unscored_n / system.finger.stiffness_n_m
    )
    # It scores by the true position within the stroke; ours is the measured one, from a turn seen a little late.
    after = run.time.values > 0.2  # the stroke begins at its end, and nobody saw that turn
    assert (~away).sum() > 1000
    assert (away != run.scored.values.astype(bool))[after].mean() < 0.005


@pytest.mark.parametrize("length_um", [11.5, 0.0])
@pytest.mark.parametrize("stiffness_n_m", [300.0, 600.0, 1000.0, 2500.0])
def test_friction_has_turned_over_where_metrics_count(stiffness_n_m, length_um):
    """Under a law that knows all, undisturbed: a skin three times as soft yields 6 mm before friction is at 0.9 N."""
    still = {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.load_drift": 0.0, "friction.roughness_rms": 0.0}
    quick = {"motion.speed_mm_s": 80.0, "finger.stiffness_n_m": stiffness_n_m, "finger.slip_length_um": length_um}
    wanted = {"controller.kind": "oracle", "setpoint": fl.Constant(offset_n=0.9), "friction.nominal_n": 1.5}
    run = fl.simulate(fl.bench().evolve(still | quick | wanted), duration_s=3.0)
    scored, late = run.scored.values.astype(bool), run.time.values > 0.5
    error_n = np.abs(run.f_a - run.f_r).values
    assert error_n[scored & late].max() < 0.02 * 0.9  # a stiff skin leaves the bristle's own way, 0.1 mm, to the end
    assert error_n[~scored & late].max() > 0.5
