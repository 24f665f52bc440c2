"""``frictionloop firmware``: the table as files, the image, and what is refused."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.cost import CORE_HZ, WORST_TICK, highest_hz
from frictionloop.firmware.emulated_core import Counted
from frictionloop.firmware import exported, image
from frictionloop.firmware.image import BOARDS
from frictionloop.quantities.schema import firmware_folder, parameter_words, word_count

PI = ("--preset", "bench", "--controller.kind", "pi", "--controller.kp", "0.06", "--controller.ki", "134")


@pytest.mark.parametrize("verb", ["export", "build"])
def test_help_has_examples_that_fit(frictionloop, monkeypatch, verb):
    monkeypatch.setenv("COLUMNS", "80")
    out = frictionloop("firmware", verb, "--help").out
    assert f"\n  frictionloop firmware {verb} " in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 80


def test_the_table_is_the_same_in_words_and_in_numbers(frictionloop, tmp_path):
    folder = tmp_path / "table"
    said = json.loads(frictionloop("firmware", "export", *PI, "--out", str(folder), "--json").out)
    words = np.frombuffer((folder / "parameters.bin").read_bytes(), "<f8")
    assert said["law"] == "pi" and len(words) == word_count() == said["words"]
    assert "table_hash" not in said
    assert said["stable"] and "LOOP-UNSTABLE" not in [each["code"] for each in said["findings"]]
    assert said["clamp_n"] == [fl.bench().controller.model.floor_n, fl.bench().controller.model.nominal_n]
    with (folder / "parameters.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    value = {row["name"]: float(row["value"]) for row in rows}
    assert np.array_equal([*value.values()], words)
    model = fl.bench().controller.model
    assert value["law.high_n"] == model.nominal_n
    assert (value["law.gains[0]"], value["law.gains[1]"]) == (0.06, 134.0)
    assert value["drive.largest_um"] == value["drive.ceiling_um"] == 2.5
    assert {row["name"].split("[")[0] for row in rows} == set(parameter_words())
    assert fl.read_toml(folder / "system.toml").controller.ki == 134


def test_gains_that_ring_on_the_bench_are_told_before_they_are_flashed(tmp_path):
    rings = fl.firmware.export(fl.bench().evolve({"controller.kp": 10.0}), tmp_path / "table")
    assert rings.stable is False and rings.findings[0].code == "LOOP-UNSTABLE"
    # In open loop nothing rings.
    assert fl.firmware.export(fl.bench().evolve({"controller.kind": "lookup"}), tmp_path / "table").stable


def test_help_lists_every_board(frictionloop, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    out = frictionloop("firmware", "build", "--help").out
    (line,) = (line for line in out.splitlines() if "--board" in line and "qemu" in line)
    assert set(BOARDS) <= set(re.findall(r"[\w-]+", line))


@pytest.mark.parametrize("kind", ["pi", "filtered_pi", "lookup"])
def test_the_cost_is_the_one_that_was_counted(tmp_path, kind):
    found = fl.firmware.export(fl.bench().evolve({"controller.kind": kind}), tmp_path / "table")
    assert found.tick_instructions == WORST_TICK[kind]
    assert found.highest_hz == pytest.approx(CORE_HZ / 20 / WORST_TICK[kind])


def test_the_table_of_the_laws_costs_is_the_one_in_use():
    text = (firmware_folder() / "README.md").read_text(encoding="utf-8")
    told = {kind: int(number) for kind, number in re.findall(r"^\| `(\w+)`[^|]* \| ([\d]+) \|", text, re.M)}
    assert told == WORST_TICK


@pytest.fixture
def built(monkeypatch, tmp_path):
    """Return a function that builds an image which takes no time."""
    made = image.Image(*(tmp_path / f"made.{kind}" for kind in ("elf", "hex", "map")), 12_345, 6789)
    monkeypatch.setattr(image, "build", lambda *_, **__: made)
    counts = Counted(1500, 400)
    monkeypatch.setattr(exported, "counted", lambda *_: counts)
    gains = {"controller.kind": "pi", "controller.kp": 0.06, "controller.ki": 134.0}

    def build(rate_hz=5000.0, **more):
        own = fl.bench().evolve(gains | {"controller.rate_hz": rate_hz})
        return fl.firmware.build(own, tmp_path / "image", board="mps2", **more)

    return build


def test_the_instructions_are_those_of_the_image_that_was_built(built):
    pytest.importorskip("unicorn")
    found = built()
    assert (found.tick_instructions, found.law_instructions) == (1500, 400)
    assert found.highest_hz == highest_hz(1500) == pytest.approx(13_200)
    assert "TICK-LATE" not in [each.code for each in found.findings]


def test_a_rate_that_the_tick_may_not_meet_is_told_and_one_far_beyond_is_refused(built, monkeypatch):
    pytest.importorskip("unicorn")
    (late,) = (each for each in built(rate_hz=20_000.0).findings if each.code == "TICK-LATE")
    assert (late.value, late.limit, late.severity) == (20_000, highest_hz(1500), "warning")
    monkeypatch.setattr(exported, "counted", lambda *_: Counted(4000, 400))
    built(rate_hz=15_625.0)
    with pytest.raises(fl.FrictionloopError, match=r"^controller.rate_hz = 20000 Hz: must be at most 19800$") as refused:
        built(rate_hz=20_000.0)
    assert refused.value.code == "TICK-LATE"


def test_an_image_in_numbers(built, tmp_path):
    said = built().to_dict()
    assert (said["board"], said["flash_bytes"], said["ram_bytes"]) == ("mps2", 12_345, 6789)
    assert (said["hex"], said["folder"]) == (str(tmp_path / "made.hex"), str(tmp_path / "image"))


@pytest.mark.slow
def test_an_image_fits(frictionloop, tmp_path):
    pytest.importorskip("ziglang")
    said = json.loads(frictionloop("firmware", "build", *PI, "--board", "mps2", "--out", str(tmp_path / "image"), "--json").out)
    lines = (tmp_path / "image" / "mps2.hex").read_text().splitlines()
    assert lines[-1] == ":00000001FF" and all(line.startswith(":") for line in lines)
    assert said["flash_bytes"] <= 32 * 1024 and said["hex"].endswith("mps2.hex")
