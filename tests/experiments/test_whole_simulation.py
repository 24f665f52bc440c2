"""Known participants through the whole simulation: their intervals hold, and memory does not grow with trials."""

import math
import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import binom, norm

from frictionloop.experiments import read_protocol
from frictionloop.experiments.simulated_participant import Observer, SimulatedParticipant
from frictionloop.experiments.study_run import simulate_trials
from frictionloop.experiments.study_summary import fits
from frictionloop.perception import force_threshold_n
from frictionloop.physics.fingers import fingers

PEOPLE = 32
GROWTH = """
import resource
from frictionloop.experiments import read_protocol
from frictionloop.experiments.study_run import simulate_trials

plan = read_protocol("study-friction").evolve({"blocks.practice": 0})
for trials in (5, 60):
    simulate_trials(plan.evolve({"stop.trials": trials}), participants=4, progress=False)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


def true_jnd_n(plan, observer, finger):
    """Return z(3/4) times the spread of the difference of two feelings at the standard, of a finger's own skin."""
    skin = SimulatedParticipant(plan, finger, 0, observer).skin
    standard = plan.stimulus.standard
    one = math.hypot(observer.weber * standard / (math.sqrt(2) * norm.ppf(0.75)), float(force_threshold_n(1.0, skin)))
    return float(norm.ppf(0.75)) * math.sqrt(2) * one


@pytest.mark.soak
@pytest.mark.timeout(1500)
def test_95_percent_intervals_hold_the_jnd_that_each_simulated_participant_has():
    """Over the level delivered; the bound is where fewer held in one of 200 such studies."""
    plan = read_protocol("jnd-friction-constant").evolve({"blocks.practice": 0})
    observer = Observer()
    people = [{**each, "friction.nominal_n": max(each["friction.nominal_n"], 0.9)} for each in fingers(PEOPLE, 5)]
    trials = simulate_trials(plan, participants=PEOPLE, observer=observer, population=people, progress=False)
    found = fits(plan, trials)
    found = found[found["level"] == "delivered"].set_index("participant")
    true = np.array([true_jnd_n(plan, observer, finger) for finger in people])
    own = found.loc[[f"P{k:02d}" for k in range(1, PEOPLE + 1)]]
    held = ((own["low"] <= true) & (true <= own["high"])).sum()
    assert held >= binom.ppf(0.005, PEOPLE, 0.95)
    assert np.nanmedian(own["value"] / true) == pytest.approx(1.0, abs=0.15)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_memory_stays_flat_over_a_study():
    done = subprocess.run([sys.executable, "-c", GROWTH], capture_output=True, text=True, check=True)
    short, long = (float(line) for line in done.stdout.split())
    assert long - short < 40.0  # MB, for 12 times as many trials; a trace of each stroke would be 400 MB
