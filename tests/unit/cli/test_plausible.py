"""Values that no bench has are asked about; those of the presets and of fingers are not."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.cli.plausible import USUAL, questions
from frictionloop.parameters.files import PRESETS


@pytest.mark.parametrize("preset", PRESETS)
def test_no_preset_is_asked_about(preset):
    assert list(questions(PRESETS[preset]())) == []


def test_no_finger_is_asked_about():
    asked = [line for each in fl.fingers(500, 1) for line in questions(fl.bench().evolve(each))]
    assert asked == []


@pytest.mark.parametrize(
    ("flag", "value", "said"),
    [
        ("plate.max_amplitude_um", "2.5e-6", "2.5e-06 um: is the unit right? Usual are 0.001 to 100 um"),
        ("sensor.noise_rms_n", "50", "50 N: is the unit right? Usual are 1e-08 to 0.5 N"),
    ],
)
def test_a_wrong_unit_is_asked_about_and_the_run_goes_on(frictionloop, flag, value, said):
    answer = frictionloop("simulate", f"--{flag}", value, "--duration-s", "0.01")
    assert (answer.code, answer.err) == (0, f"{flag} = {said}\n")


def test_nothing_is_no_question():
    assert list(questions(fl.paper().evolve({"sensor.noise_rms_n": 0.0, "disturbance.amplitude_n": 0.0}))) == []


def test_the_names_are_names_of_parameters():
    names = {key for make in PRESETS.values() for _, block in make() for key in type(block).model_fields}
    assert set(USUAL) - names == set()
