"""Which samples of a recording count: those that `simulate` would count."""

from __future__ import annotations

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH

import frictionloop as fl
from frictionloop.device.recording import counted

BENCH = fl.bench().evolve(DESIGNED_NOTCH)


def test_a_recording_scores_as_the_simulation_does() -> None:
    with fl.connect("sim:", BENCH) as device:
        run = device.run(BENCH.setpoint, 4.0)
    simulated = fl.simulate(BENCH, 4.0)
    assert fl.rms_error(run) == pytest.approx(fl.rms_error(simulated), rel=0.05)
    # The position that is measured has 10 um of noise and the tremor, 30 um; the stroke that is meant has neither.
    late = run.attrs["start_tick"] - 1
    other = run.scored.values[: 20000 - late] != simulated.scored.values[late:]
    edge = abs(abs(simulated.position.values[late:]) - 28e-3)
    assert edge[other].max() < 6 * 40e-6


def test_what_counts_with_strokes_and_without() -> None:
    sliding = np.array([True, True, True, True, True, False, False])
    position = np.array([0.0, 27.9e-3, -28.1e-3, 0.0, 0.0, 0.0, np.nan])
    load = np.array([0.5, 0.5, 0.5, 0.26, 0.24, 0.5, np.nan])  # strokes of 60 mm, 2 mm unscored, under 0.5 N
    assert counted(sliding, position, load, BENCH).tolist() == [True, True, False, True, False, False, False]
    soft = BENCH.evolve({"finger.stiffness_n_m": 400.0})  # whose skin yields 5 mm
    assert not counted(sliding, position, load, soft)[1]
    assert counted(sliding, position, load, None).tolist() == sliding.tolist()
    assert counted(sliding, position, load, fl.paper()).tolist() == sliding.tolist()
