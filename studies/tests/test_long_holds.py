"""What rings has a line, steps come in rounds, and a law that begins anew is another run of the same finger."""

from __future__ import annotations

import numpy as np
import pytest

from frictionloop.parameters import bench
from frictionloop.physics.fingers import fingers
from studies.conditions import limit_observer
from studies.histories import CONSTANT, LEVEL_N
from studies.long_holds import PIECE_S, ROUND_S, STEPS_S, forces, line, steps


def test_a_ringing_has_a_line_and_noise_has_none():
    time, noise = np.arange(2500) / 5000.0, np.random.default_rng(1).standard_normal(2500)
    assert line(np.sin(2.0 * np.pi * 180.0 * time) + 0.1 * noise, 5000.0) > 0.9
    assert line(noise, 5000.0) < 0.3


def test_every_round_of_steps_ends_in_a_hold():
    found = steps(90.0)
    assert len(found.times_s) == len(found.levels_n)
    assert np.all(np.diff(found.times_s) > 0.0)
    for begin in (0.0, ROUND_S, 2 * ROUND_S):
        assert found.levels_n[found.times_s.index(begin + STEPS_S)] == LEVEL_N
        assert sum(begin <= time < begin + STEPS_S for time in found.times_s) > 48


@pytest.mark.slow
def test_a_law_begun_anew_differs_from_the_one_that_went_on_and_comes_back_to_it():
    system = bench().evolve({"setpoint": CONSTANT, **limit_observer(11.5)})
    on, anew = (forces(system, fingers(2, 3), 2 * PIECE_S, anew=anew) for anew in (False, True))
    half = on.shape[1] // 2
    assert np.array_equal(on[:, :half], anew[:, :half])
    assert np.abs(on - anew)[:, half : half + 500].max() > 1e-3
    assert np.abs(on - anew)[:, -2500:].max() < np.abs(on - anew).max() / 10
