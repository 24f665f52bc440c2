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


def test_a_controller_that_believes_another_bench_is_told_with_both_values():
    told = list(questions(fl.bench().evolve({"sensor.resonance_hz": 170.0})))
    assert told == [
        "sensor.resonance_hz = 170 Hz, but controller.model.resonance_hz = 145 Hz; "
        "if it is not meant: --controller.model.resonance_hz 170"
    ]
    assert list(questions(fl.bench().evolve({"sensor.resonance_hz": 150.0}))) == []


def test_a_file_that_changes_a_kind_is_told_what_is_not_taken_over(frictionloop, tmp_path):
    text = 'preset = "bench"\n[controller]\nkind = "notch_pi"\nki = 80\n'
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    answer = frictionloop("simulate", "mine.toml", "--duration-s", "0.01")
    left = "mine.toml: controller.kind = notch_pi: kp = 3.8 by default; what the pi had is not taken over"
    assert left in answer.err.splitlines()
