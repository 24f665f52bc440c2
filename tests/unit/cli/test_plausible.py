"""Values that no bench has are asked about; those of the presets and of fingers are not."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.cli.plausible import BELIEVED, USUAL, differing, questions
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
        (
            "plate.max_amplitude_um",
            "2.5e-6",
            "2.5e-06 um: is the unit right? Usual are 0.05 to 50 um; did you mean 2.5 um?",
        ),
        ("sensor.noise_rms_n", "50", "50 N: is the unit right? Usual are 1e-08 to 0.5 N; did you mean 5e-05 N?"),
    ],
)
def test_a_wrong_unit_is_asked_about_and_the_run_goes_on(frictionloop, flag, value, said):
    answer = frictionloop("simulate", f"--{flag}", value, "--duration-s", "0.01")
    assert (answer.code, answer.err) == (0, f"{flag} = {said}\n")


def test_a_carrier_in_kilohertz_is_asked_about_before_the_search(frictionloop, monkeypatch):
    def late(*_):
        raise fl.FrictionloopError("the resonance is the limit")

    monkeypatch.setattr("frictionloop.design.synthesis.design_controller", late)
    said = frictionloop("design", "controller", "--plate.frequency_hz", "38.5", "--law", "pi", "--out", "n.toml").err
    first, carrier, last = said.splitlines()
    assert first.startswith("plate.frequency_hz = 38.5 Hz: is the unit right?") and "did you mean 38500 Hz?" in first
    assert "the board's carrier must be from 1099 Hz" in carrier
    assert last == "error: the resonance is the limit"


def test_a_refused_delay_in_microseconds_names_what_was_meant(frictionloop, tmp_path):
    said = frictionloop("simulate", "--preset", "bench", "--controller.delay_s", "250").err
    assert "controller.delay_s = 250 s: must be" in said and said.endswith("did you mean 0.00025 s?\n")
    (tmp_path / "mine.toml").write_text('preset = "bench"\n[controller]\ndelay_s = 250\n')
    assert frictionloop("simulate", "mine.toml").err.endswith("did you mean 0.00025 s?\n")


def test_nothing_is_no_question():
    assert list(questions(fl.paper().evolve({"sensor.noise_rms_n": 0.0, "disturbance.amplitude_n": 0.0}))) == []


def test_the_names_are_names_of_parameters():
    names = {key for make in PRESETS.values() for _, block in make() for key in type(block).model_fields}
    assert set(USUAL) - names == set()


NOTCH = {"controller.kind": "notch_pi", "controller.feedforward": True, "controller.overdrive": True}


@pytest.mark.parametrize(
    ("law", "changes", "names"),
    [
        ({"controller.kind": "limit_observer"}, {"sensor.resonance_hz": 160.0}, ["sensor.resonance_hz"]),
        ({"controller.kind": "limit_observer"}, {"controller.model.sensor_hz": 300.0}, ["sensor.cutoff_hz"]),
        (NOTCH, {"plate.q": 180.0, "sensor.q": 15.0}, ["plate.cutoff_hz", "sensor.q"]),
        (NOTCH | {"controller.feedforward": False}, {"plate.q": 180.0, "sensor.q": 15.0}, ["plate.cutoff_hz"]),
        (NOTCH, {"sensor.resonance_hz": 160.0, "controller.model.resonance_hz": 150.0}, []),
        (NOTCH, {"friction.nominal_n": 0.9}, []),
        (NOTCH, {"plate.max_amplitude_um": 3.0}, ["plate.max_amplitude_um"]),
        ({"controller.kind": "pi"}, {"plate.q": 180.0, "sensor.resonance_hz": 160.0, "sensor.q": 15.0}, []),
        ({"controller.kind": "lookup"}, {"plate.q": 180.0, "sensor.resonance_hz": 160.0}, []),
    ],
)
def test_a_value_that_law_and_plant_have_differently_is_asked_about_where_one_was_given(law, changes, names):
    system = fl.bench().evolve({**law, **changes})
    assert [line.split(" is ")[0] for line in differing(system, {*law, *changes})] == names


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_has_no_such_difference(preset):
    for law in ("pi", "limit_observer", "notch_pi"):
        made = PRESETS[preset]()
        assert list(differing(made, ())) == list(differing(made, (), law)) == []


@pytest.mark.slow
def test_a_design_asks_about_the_model_of_a_file_that_describes_the_sensor_alone(frictionloop, tmp_path):
    (tmp_path / "mine.toml").write_text('schema = 1\npreset = "bench"\n[sensor]\nresonance_hz = 160.0\n')
    assert frictionloop("simulate", "mine.toml", "--duration-s", "0.01").err == ""
    (tmp_path / "mine.toml").write_text((tmp_path / "mine.toml").read_text() + "cutoff_hz = 900.0\n")
    said = frictionloop("design", "controller", "mine.toml", "--law", "notch_pi").err
    assert said == (
        "sensor.cutoff_hz is 900 Hz, and the controller believes 1000 Hz; if it is to know: "
        "controller.model.sensor_hz = 900\n"
    )
    named = "[controller.model]\nsensor_hz = 900.0\n"
    (tmp_path / "mine.toml").write_text((tmp_path / "mine.toml").read_text() + named)
    assert frictionloop("design", "controller", "mine.toml", "--law", "notch_pi").err == ""


@pytest.mark.slow
@pytest.mark.parametrize("law", ["notch_pi", "limit_observer"])
def test_a_design_saves_the_resonance_that_it_went_by_as_what_the_controller_believes(frictionloop, law):
    words = ("--sensor.resonance_hz", "180", "--controller.model.resonance_hz", "145", "--law", law, "--out", "c.toml")
    answer = frictionloop("design", "controller", *words)
    assert (answer.code, answer.err) == (0, "")
    found = fl.read_toml("c.toml")
    assert 145.0 < found.controller.model.resonance_hz <= 180.0  # an observer's is best a little low
    assert "model.resonance_hz" in answer.out
    if law == "notch_pi":
        assert found.controller.model.resonance_hz == 180.0
        said = " ".join(answer.out.split())
        assert "controller.model.resonance_hz = 180: set to the sensor's, for which the notch is made" in said


def test_a_design_does_not_ask_about_what_it_sets_itself():
    system = fl.bench().evolve({"sensor.resonance_hz": 180.0, "sensor.q": 15.0, "sensor.cutoff_hz": 900.0})
    named = ["sensor.resonance_hz", "sensor.q", "sensor.cutoff_hz"]
    asked = {
        law: [line.split(" is ")[0] for line in differing(system, named, law)] for law in ("notch_pi", "limit_observer")
    }
    assert asked == {"notch_pi": ["sensor.cutoff_hz"], "limit_observer": []}


def test_what_a_controller_believes_is_a_field_of_its_model():
    assert BELIEVED.keys() <= type(fl.bench().controller.model).model_fields.keys()


PLATE = "plate.max_amplitude_um = 0.0025 um: is the unit right? Usual are 0.05 to 50 um; did you mean 2.5 um?"


@pytest.mark.parametrize(
    "verb",
    [
        ("simulate", "FILE", "--duration-s", "0.01"),
        ("sweep", "FILE", "--over", "controller.ki=1,2", "--duration-s", "0.01"),
        ("sweep", "--over", "plate.max_amplitude_um=0.0025,2", "--duration-s", "0.01"),
        ("firmware", "export", "FILE", "--out", "."),
        ("effect", "show", "bump", "FILE"),
    ],
)
def test_every_verb_asks_about_a_file_and_about_what_is_swept(frictionloop, tmp_path, verb):
    (tmp_path / "mine.toml").write_text('preset = "bench"\n[plate]\nmax_amplitude_um = 0.0025\n')
    answer = frictionloop(*("mine.toml" if each == "FILE" else each for each in verb))
    assert PLATE in answer.err.splitlines()
    assert answer.err.count("is the unit right?") == 1


def test_what_takes_minutes_asks_before(frictionloop, tmp_path, monkeypatch):
    def late(*_, **__):
        raise fl.FrictionloopError("that was the work")

    monkeypatch.setattr("frictionloop.design.comparison.compare", late)
    monkeypatch.setattr("frictionloop.design.synthesis.design_controller", late)
    (tmp_path / "mine.toml").write_text('preset = "bench"\n[plate]\nmax_amplitude_um = 0.0025\n')
    for verb in (("compare", "mine.toml"), ("design", "controller", "mine.toml", "--law", "pi")):
        first, *_, last = frictionloop(*verb).err.splitlines()
        assert (first, last) == (PLATE, "error: that was the work")


def test_designs_of_parts_are_asked_about_too(frictionloop, tmp_path):
    (tmp_path / "sensor.toml").write_text("schema = 1\n[electrodes]\ngap_um = 1e5\n")
    said = frictionloop("design", "sensor", "sensor.toml").err
    assert "electrodes.gap_um = 100000 um: is the unit right? Usual are 5 to 5000 um; did you mean 100 um?" in said
    said = frictionloop("design", "plate", "--geometry.thickness_mm", "0.003").err
    assert "geometry.thickness_mm = 0.003 mm: is the unit right? Usual are 0.1 to 20 mm; did you mean 3 mm?" in said
    for part in ("sensor", "plate"):
        assert "is the unit right?" not in frictionloop("design", part).err


def test_a_drive_that_the_controller_believes_stronger_is_told():
    weak = fl.bench().evolve({"plate.max_amplitude_um": 1.5})
    (line,) = differing(weak, {"plate.max_amplitude_um"})
    assert line == (
        "plate.max_amplitude_um is 1.5 um, and the controller believes 2.5 um; if it is to know: "
        "controller.model.max_amplitude_um = 1.5"
    )
    assert list(differing(weak, {"plate.max_amplitude_um", "controller.model.max_amplitude_um"})) == []
    assert list(differing(weak, set())) == []


def test_a_flag_that_changes_the_plant_of_a_file_written_whole_is_told_where_the_controller_does_not_follow(
    frictionloop,
):
    fl.write_toml(fl.bench(), "whole.toml")
    words = ("simulate", "whole.toml", "--duration-s", "0.01", "--plate.max_amplitude_um")
    (said,) = frictionloop(*words, "4").noted
    assert said.startswith("plate.max_amplitude_um is 4 um, and the controller believes 2.5 um and asks for no more;")
    assert frictionloop(*words, "4", "--controller.model.max_amplitude_um", "4").noted == []
    assert frictionloop("simulate", "whole.toml", "--duration-s", "0.01").noted == []
    only_thought = ("--controller.model.max_amplitude_um", "2.2")
    assert frictionloop("simulate", "whole.toml", "--duration-s", "0.01", *only_thought).noted == []


def test_a_plant_edited_in_a_file_written_whole_is_told_where_the_controller_believes_that_of_the_preset(frictionloop):
    words = ("--plate.q", "46", "--controller.kind", "notch_pi", "--controller.overdrive", "true", "--save-system")
    frictionloop("simulate", "--preset", "bench", *words, "faster.toml")
    (said,) = frictionloop("simulate", "faster.toml", "--duration-s", "0.01").noted
    assert said.startswith("plate.cutoff_hz is 500 Hz, and the controller believes 100 Hz; if it is to know:")
    believed = ("--controller.model.plate_hz", "90")  # who says so on the line means it
    assert frictionloop("simulate", "faster.toml", "--duration-s", "0.01", *believed).noted == []


@pytest.mark.parametrize("verb", [("simulate",), ("sweep", "--fingers", "2")])
def test_a_ceiling_of_the_board_that_a_simulation_leaves_out_is_told(frictionloop, verb):
    words = (*verb, "--preset", "bench", "--duration-s", "0.2", "--board.ceiling_um")
    said = [each for each in frictionloop(*words, "0.5").noted if "ceiling" in each]
    assert said == [
        "board.ceiling_um = 0.5 um holds on a board alone: what is simulated here goes up to 2.5 um "
        "(plate.max_amplitude_um)"
    ]
    assert not any("ceiling" in each for each in frictionloop(*words, "2.5").noted)
