"""Effects through the calls that a board on the desk takes: recorded, exchanged while the finger slides, triggered."""

from __future__ import annotations

import json

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.laws import LAWS
from frictionloop.firmware.effect_tables import effect_tables, write_tables
from frictionloop.firmware.image import build
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.rendering.effect_setpoint import EffectSource

R = fl.rendering
SYSTEM = fl.bench().evolve(fl.RETUNED)
RAMP = R.Gradient(from_n=0.3, to_n=0.7, length_mm=80.0)


@pytest.fixture(scope="module")
def device():
    with fl.connect("sim:", SYSTEM) as opened:
        yield opened


def test_an_effect_is_asked_for_where_the_finger_is(device):
    run = device.run(RAMP, 0.6)
    wanted = RAMP.force_of(R.Touch(x_mm=1e3 * run.position.values))
    np.testing.assert_allclose(run.f_r.values[100:], wanted[100:], atol=2e-3)  # 0.4 mm of noise and lead
    assert np.ptp(run.f_r.values) > 0.02
    assert run.attrs["setpoint_error_n"] < 1e-4


def test_the_recording_says_which_effect_it_was(device):
    run = device.run(EffectSource(effect=RAMP, position="measured"), 0.1)
    assert "measured" in str(run.attrs["system"])


def test_another_effect_while_the_finger_slides(device):
    assert device.play(R.Constant(level_n=0.4)) == ()
    device.mode("closed")
    told = []
    for number, block in enumerate(device.stream(0.4, 1)):
        told.append(block["f_r"])
        if number == 2:
            device.play(R.Constant(level_n=0.5))
    forces = np.concatenate(told)
    device.mode("idle")
    assert forces[0] == pytest.approx(0.4, abs=1e-4)
    assert forces[-1] == pytest.approx(0.5, abs=1e-4)
    band = SYSTEM.controller.model.nominal_n - SYSTEM.controller.model.floor_n
    step = band / (SYSTEM.board.ramp_s * 5000)
    assert np.max(np.abs(np.diff(forces))) == pytest.approx(step, abs=1.1e-4)  # telemetry has steps of 0.1 mN


def test_what_is_sampled_more_coarsely_is_told(device):
    (found,) = device.play(R.Texture(longest_mm=2.0))
    assert found.code == "EFFECT-COARSER" and found.more["step"] == 0
    assert found.value < found.limit and found.more["error"] > 0


def test_the_tables_as_a_file_say_what_the_words_say(tmp_path):
    tables = effect_tables(EffectSource(effect=R.find("button")), 255.0)
    write_tables(tables, tmp_path / "button.json")
    read = json.loads((tmp_path / "button.json").read_text())
    assert [step["what"] for step in read["steps"]] == [
        "trigger", "table", "table", "mix", "wave", "add", "wave", "add",
    ]  # fmt: skip
    assert read["words"] == tables.words.tolist()
    wave = read["steps"][4]
    first = wave["first"]
    values = np.array(read["words"][first : first + wave["count"]]) * wave["scale"] / 2**15
    np.testing.assert_allclose(values, R.find("button").starts.values_n, atol=1e-5)


@pytest.mark.slow
def test_the_image_plays_what_the_library_plays(tmp_path):
    image = build("teensy41-ads8688", firmware_words(SYSTEM).tolist(), board_law(LAWS["pi"]), tmp_path, rate_hz=5000)
    with fl.connect(f"emulated:{image.elf}", SYSTEM) as board, fl.connect("sim:", SYSTEM) as library:
        run, same = (
            each.run(R.find("bump") + R.Grating(offset_n=0.0, amplitude_n=0.1), 0.5) for each in (board, library)
        )
    shift = run.attrs["start_tick"] - same.attrs["start_tick"]
    late = slice(200, 2000)  # until then the direction is that of the beginning
    np.testing.assert_array_equal(run.f_r.values[late], same.f_r.values[shift:][late])
