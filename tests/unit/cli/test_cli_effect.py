"""The commands of effects: their help, and what they change and bring in without code."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

import frictionloop as fl

R = fl.rendering


@pytest.mark.parametrize("verb", ["list", "show", "check", "play", "import"])
@pytest.mark.parametrize("columns", [80, 120])
def test_help_has_examples_that_fit(frictionloop, monkeypatch, verb, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = frictionloop("effect", verb, "--help")
    assert f"\n  frictionloop effect {verb}" in answer.out
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= columns


def test_an_effect_is_changed_without_code(frictionloop):
    change = ("--effect.of.1.height_mm", "0.7", "--effect.of.0.level_n", "0.4", "--motion.speed_mm_s", "100")
    answer = frictionloop("effect", "show", "bump", *change, "--save", "mine.toml")
    assert (answer.code, answer.noted) == (0, [])
    assert R.read_effect("mine.toml") == R.Constant(level_n=0.4) + R.Ridge(height_mm=0.7)
    assert frictionloop("effect", "check", "mine.toml", "--json").json()["largest_n"] == pytest.approx(
        0.4 + 0.1833, abs=1e-3
    )


def test_a_picture_of_heights_and_a_model_of_a_recording_come_in_without_code(frictionloop):
    Image.fromarray(np.tile(np.arange(0, 200, 4, dtype=np.uint8), (4, 1))).save("ramp.png")
    scale = ("--mm-per-pixel", "0.2", "--polarity", "bright", "--low-n", "0", "--high-n", "1")
    assert frictionloop("effect", "import", "ramp.png", *scale, "--heights", "--out", "ramp.toml").code == 0
    slope = 4 / 255 / 0.2
    force = R.read_effect("ramp.toml").force_n(R.Touch(x_mm=0.3, speed_mm_s=20.0))
    assert force == pytest.approx(0.45 + 0.5 * slope, rel=1e-6)
    np.savetxt("cloth.csv", np.random.default_rng(0).standard_normal(4000), header="force", comments="")
    recorded = ("--column", "force", "--rate-hz", "1000", "--scale", "0.01")
    words = ("effect", "import", "cloth.csv", *recorded, "--order", "3", "--out", "model.toml")
    assert "order = 3: goes with speed_mm_s" in frictionloop(*words).err
    assert frictionloop(*words, "--speed-mm-s", "40").code == 0
    assert len(R.read_effect("model.toml").coefficients) == 3


def test_a_wave_alone_is_not_said_to_ask_for_nothing(frictionloop):
    """It is over after its last value; what it asks for is what it asked for until then."""
    R.write_effect(R.Wave(values_n=(0.3, 0.5, 0.4), rate_hz=10.0), "wave.toml")
    found = frictionloop("effect", "check", "wave.toml", "--json").json()
    assert found["least_n"] == 0.0  # afterwards
    assert found["largest_n"] == pytest.approx(0.5, abs=1e-3)
    R.write_effect(R.Wave(values_n=(0.01, 0.02, 0.01), rate_hz=10.0), "faint.toml")
    refused = frictionloop("effect", "check", "faint.toml")
    assert refused.code == 2
    assert refused.err.startswith("error: effect = 0 to 0.02 N: must have")


def test_effects_are_listed_with_all_that_touch_makes_of_them():
    """A button is pressed, velvet stroked back, liquid stroked fast."""
    forces = {each.name: (each.least_n, each.largest_n) for each in R.effects().effects}
    wanted = {"button": (0.15, 0.63), "velvet": (0.331, 0.519), "liquid": (0.29, 0.45), "grating": (0.3, 0.6)}
    assert {name: forces[name] for name in wanted} == {k: pytest.approx(v, abs=1e-3) for k, v in wanted.items()}


def test_check_says_what_the_skin_lets_through_of_a_period(frictionloop):
    found = frictionloop("effect", "check", "grating", "--effect.spacing_mm", "0.05", "--json").json()
    assert (found["skin_n_mm"], found["skin_amplitude_n"]) == (1.0, pytest.approx(0.008, abs=1e-4))
    assert "EFFECT-STEEP" in {each["code"] for each in found["findings"]}


def test_check_asks_at_the_speed_of_show(frictionloop):
    told = frictionloop("effect", "check", "grating", "--effect.spacing_mm", "0.5", "--speed-mm-s", "2000")
    assert told.code != 0 and "2000 mm/s" in told.err


def test_a_flag_that_says_nothing_about_a_file_is_refused(frictionloop):
    Image.fromarray(np.zeros((4, 4), np.uint8)).save("grey.png")
    scale = ("--mm-per-pixel", "0.2", "--polarity", "bright", "--out", "grey.toml")
    answer = frictionloop("effect", "import", "grey.png", *scale, "--speed-mm-s", "30")
    assert answer.code == 2
    assert answer.err.startswith("error: speed_mm_s: goes with .csv .tsv")


def test_a_recording_without_a_scale_is_told_to_be_taken_for_newtons(frictionloop):
    np.savetxt("force.csv", np.full(100, 0.4), header="force", comments="")
    answer = frictionloop("effect", "import", "force.csv", "--rate-hz", "1000", "--out", "force.toml", "--json").json()
    assert [each["code"] for each in answer["findings"]] == ["SCALE-TAKEN"]
    assert (answer["least_n"], answer["largest_n"]) == (0.0, pytest.approx(0.4))
    assert R.import_effect("force.csv", rate_hz=1000.0, scale=1.0).findings == ()


def test_the_line_of_the_stroke_is_changed_without_code(frictionloop):
    R.write_effect(R.Map(values_n=((0.3, 0.3), (0.5, 0.5)), pitch_mm=4.0), "rows.toml")
    for y_mm, force in (("0", 0.3), ("4", 0.5)):
        answer = frictionloop("effect", "check", "rows.toml", "--setpoint.track.y_mm", y_mm, "--json")
        assert answer.json()["largest_n"] == pytest.approx(force)
    wrong = frictionloop("effect", "check", "rows.toml", "--setpoint.position", "guessed")
    assert wrong.code == 2
    assert "setpoint.position = 'guessed': must be 'measured' or 'predicted'" in wrong.err
