"""Values that no bench has are asked about, and those that plant and controller have differently; presets are not."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.parameters.doubtful_values import BELIEVED, differing, named_by, of_axes, of_ceiling, unusual
from frictionloop.parameters.refusals import USUAL
from frictionloop.parameters.toml_reader import PRESETS


@pytest.mark.parametrize("preset", PRESETS)
def test_no_preset_is_asked_about(preset):
    assert list(unusual(PRESETS[preset]())) == []


def test_no_finger_is_asked_about():
    assert [found for each in fl.fingers(500, 1) for found in unusual(fl.bench().evolve(each))] == []


@pytest.mark.parametrize(
    ("path", "value", "meant"),
    [("plate.max_amplitude_um", 2.5e-6, 2.5), ("sensor.noise_rms_n", 50.0, 5e-5), ("motion.speed_mm_s", 0.02, 20.0)],
)
def test_a_wrong_unit_is_asked_about_with_what_may_be_meant(path, value, meant):
    base = fl.paper() if path.startswith("sensor") else fl.bench()
    found = [each for each in unusual(base.evolve({path: value})) if each.more["path"] == path]
    assert [(each.code, each.value) for each in found] == [("UNIT-DOUBT", value)]
    assert found[0].remedy == {path: pytest.approx(meant)}
    assert found[0].more["low"] <= meant <= found[0].more["high"]


def test_a_value_of_a_file_is_asked_about_in_what_describes_it(tmp_path):
    (tmp_path / "mine.toml").write_text('preset = "bench"\n[plate]\nmax_amplitude_um = 0.0025\n')
    (doubt,) = [each for each in fl.described(tmp_path / "mine.toml").findings if each.code == "UNIT-DOUBT"]
    assert doubt.remedy == {"plate.max_amplitude_um": pytest.approx(2.5)}


def test_nothing_is_no_question():
    assert list(unusual(fl.paper().evolve({"sensor.noise_rms_n": 0.0, "disturbance.amplitude_n": 0.0}))) == []


def test_the_names_are_names_of_parameters():
    designs = fl.design.PlateDesign(), fl.design.SensorDesign()
    names = {key for make in PRESETS.values() for _, block in make() for key in type(block).model_fields}
    names |= {key for design in designs for _, block in design for key in type(block).model_fields}
    assert set(USUAL) - names == set()
    assert BELIEVED.keys() <= type(fl.bench().controller.model).model_fields.keys()


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
    assert [each.more["path"] for each in differing(system, {*law, *changes})] == names


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_has_no_such_difference(preset):
    for law in ("pi", "limit_observer", "notch_pi"):
        made = PRESETS[preset]()
        assert list(differing(made, ())) == list(differing(made, (), law)) == []


def test_a_design_does_not_ask_about_what_it_sets_itself():
    system = fl.bench().evolve({"sensor.resonance_hz": 180.0, "sensor.q": 15.0, "sensor.cutoff_hz": 900.0})
    named = ["sensor.resonance_hz", "sensor.q", "sensor.cutoff_hz"]
    asked = {
        law: [each.more["path"] for each in differing(system, named, law)] for law in ("notch_pi", "limit_observer")
    }
    assert asked == {"notch_pi": ["sensor.cutoff_hz"], "limit_observer": []}


def test_a_drive_that_the_controller_believes_stronger_is_told():
    weak = fl.bench().evolve({"plate.max_amplitude_um": 1.5})
    (told,) = differing(weak, {"plate.max_amplitude_um"})
    assert (told.code, told.value, told.limit) == ("BELIEF-DIFFERS", 1.5, 2.5)
    assert told.remedy == {"controller.model.max_amplitude_um": 1.5}
    assert list(differing(weak.evolve(told.remedy), {"plate.max_amplitude_um"})) == []
    assert list(differing(weak, {"plate.max_amplitude_um", "controller.model.max_amplitude_um"})) == []
    assert list(differing(weak, set())) == []


def test_a_plant_that_changes_in_a_file_written_whole_is_told_where_the_controller_does_not_follow(tmp_path):
    whole, name = tmp_path / "whole.toml", "plate.max_amplitude_um"
    fl.write_toml(fl.bench(), whole)
    model = f"controller.model.{name.partition('.')[2]}"
    assert [each.code for each in fl.described(whole, overrides={name: 4.0}).findings] == ["BELIEF-DIFFERS"]
    for fine in ({}, {name: 4.0, model: 4.0}, {model: 2.2}):
        assert fl.described(whole, overrides=fine).findings == ()
    assert named_by({name: 4.0, model: 2.5}, ()) == {name}


def test_a_design_asks_about_the_model_of_a_file_that_describes_the_sensor_alone(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('schema = 1\npreset = "bench"\n[sensor]\nresonance_hz = 160.0\ncutoff_hz = 900.0\n')
    (told,) = fl.described(file, law="notch_pi").findings
    assert told.remedy == {"controller.model.sensor_hz": 900.0}
    file.write_text(file.read_text() + "[controller.model]\nsensor_hz = 900.0\n")
    assert fl.described(file, law="notch_pi").findings == ()


@pytest.mark.slow
@pytest.mark.parametrize("law", ["notch_pi", "limit_observer"])
def test_a_design_sets_the_resonance_that_it_went_by_as_what_the_controller_believes(law):
    bench = fl.bench().evolve({"sensor.resonance_hz": 180.0, "controller.model.resonance_hz": 145.0})
    found = fl.design.controller(bench, law)
    believed = found.system.controller.model.resonance_hz
    assert 145.0 < believed <= 180.0  # an observer's is best a little low
    told = [each.value for each in found.findings if each.code == "MODEL-SET"]
    assert told == ([{"controller.model.resonance_hz": 180.0}] if law == "notch_pi" else [])


def test_what_is_swept_is_asked_about_by_its_farthest_value():
    (told,) = of_axes({"plate.max_amplitude_um": [0.0025, 2.0], "controller.ki": [1.0, 2.0]})
    assert told.value == 0.0025


def test_a_ceiling_of_the_board_that_a_simulation_leaves_out_is_told():
    (told,) = of_ceiling(fl.bench().evolve({"board.ceiling_um": 0.5}))
    assert (told.code, told.value, told.limit) == ("BOARD-CEILING", 0.5, 2.5)
    assert list(of_ceiling(fl.bench().evolve({"board.ceiling_um": 2.5}))) == []
