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


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (
            "of.1.height",
            "effect.of.1.height: is unknown; accepted instead of 'height': kind, height_mm, width_mm, load_n",
        ),
        ("of.2.height_mm", "effect.of.2.height_mm: is unknown; accepted instead of '2': 0, 1"),
        ("of.1.width_mm", "effect: of.1.width_mm = -1 mm: must be greater than 0"),
    ],
)
def test_what_an_effect_does_not_have_is_one_line(frictionloop, change, line):
    answer = frictionloop("effect", "check", "bump", f"--effect.{change}=-1")
    assert (answer.code, answer.out) == (2, "")
    assert line in answer.err


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
    assert "order = 3: goes with --speed-mm-s" in frictionloop(*words).err
    assert frictionloop(*words, "--speed-mm-s", "40").code == 0
    assert len(R.read_effect("model.toml").coefficients) == 3
