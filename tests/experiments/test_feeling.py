"""What a simulated participant feels of a pattern, by closed form and in whole strokes."""

import numpy as np
import pandas
import pytest

import frictionloop as fl
from frictionloop.experiments import Protocol, fits, read_protocol
from frictionloop.experiments.simulated_participant import (
    Observer,
    SimulatedParticipant,
    asked_along,
    strength_along,
    strength_of_period,
)
from frictionloop.experiments.study_run import study_system

RIDGE = Protocol(
    task="yes_no",
    attribute="pattern",
    level_unit="mm",
    stimulus={
        "field": "of.1.height_mm",
        "adds": False,
        "effect": {"kind": "sum", "of": [{"kind": "constant", "level_n": 0.45}, {"kind": "ridge", "width_mm": 4.0}]},
    },
    method={"kind": "psi", "low": 0.0, "high": 0.25, "spread": (0.01, 0.2)},
)
GRATING = Protocol(
    task="yes_no",
    attribute="pattern",
    stimulus={"field": "amplitude_n", "adds": False, "effect": {"kind": "grating", "offset_n": 0.45}},
    method={"kind": "psi", "low": 0.0, "high": 0.1},
)


def test_a_strength_is_the_rms_of_what_goes_along():
    rng = np.random.default_rng(0)
    known, place = rng.normal(size=5000), np.linspace(0.0, 20.0, 5001)[:-1]
    across = rng.normal(size=5000)
    across -= known * (across @ known) / (known @ known)
    assert strength_along(3.0 * known + across, known) == pytest.approx(3.0 * np.sqrt(np.mean(known**2)))
    assert strength_along(across, known) == pytest.approx(0.0, abs=1e-12)
    assert strength_along(across, np.zeros(5000)) == 0.0
    wave = 2.0 * np.sin(2 * np.pi * place / 4.0 + 0.7)
    assert strength_of_period(wave, place, 4.0) == pytest.approx(np.sqrt(2.0))
    assert strength_along(wave, wave) == pytest.approx(np.sqrt(2.0))


@pytest.mark.parametrize(("task", "exponent"), [("friction", 0.5), ("pattern", 0.5), ("pattern", 0.8)])
def test_told_magnitudes_have_the_exponent_of_the_observer(task, exponent, monkeypatch):
    plan = read_protocol("magnitude-estimation").evolve({"attribute": task})
    sizes, held = np.tile(np.geomspace(0.3, 10.0, 6), 10), 0
    monkeypatch.setattr(SimulatedParticipant, "percept", lambda self, size: (size, np.hypot(0.7, 0.2 * size)))
    for seed in range(20):
        person = SimulatedParticipant(plan, {}, seed, Observer(exponent=exponent))
        told = [float(person.answers(trial, 1, [size])[0]) for trial, size in enumerate(sizes)]
        rows = {"participant": "P", "condition": "closed", "counted": 1, "requested": sizes, "result": told}
        found = fits(plan, pandas.DataFrame(rows), ("requested",)).iloc[0]
        held += found["low"] <= exponent <= found["high"]
    assert held >= 16  # 0.1 % of 20 that hold in 95 %
    assert min(told) > 1.0


@pytest.mark.slow
@pytest.mark.parametrize("plan", [RIDGE, GRATING])
def test_a_pattern_that_is_not_there_is_denied_and_a_strong_one_is_told(plan):
    """The force of the loop itself, ten times its threshold and more, is not taken for the pattern."""
    person = SimulatedParticipant(plan, {}, 0, Observer(lapse=0.0))
    felt = []
    for level in plan.method.extremes():
        effect = plan.stimulus.at(level)
        system = study_system().evolve({"setpoint": {"kind": "effect", "effect": effect.model_dump()}})
        run = fl.simulate(system.evolve({"motion.stroke_mm": 48.0}), 1.5)
        felt.append(person.percept(run)[0])
        assert asked_along(effect, run) == pytest.approx(run["f_r"].values, abs=1e-2)
    assert felt[0] < 1.0 < felt[1]
