"""Samples near a turn: a triangle in closed form, and the simulator's own rule about its strokes."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device.recording import away_from_turns


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
