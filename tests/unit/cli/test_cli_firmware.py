"""``frictionloop firmware``: the table as files, the image, and what is refused."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.instruction_cost import BEYOND, WORST_TICK, highest_rate_hz, worst_tick
from frictionloop.device.emulator import budget
from frictionloop.firmware import image
from frictionloop.firmware.image import BOARDS
from frictionloop.quantities.protocol_schema import firmware_folder, parameter_words, word_count

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
    about = re.search(r"--board STR(.*?)--out", out, re.DOTALL)[1]
    assert set(BOARDS) <= set(re.findall(r"[\w-]+", about))


@pytest.mark.parametrize("kind", ["pi", "filtered_pi", "lookup"])
def test_the_cost_is_the_one_that_was_counted(tmp_path, kind):
    found = fl.firmware.export(fl.bench().evolve({"controller.kind": kind}), tmp_path / "table")
    assert found.worst_tick_instructions == worst_tick(kind)
    assert found.highest_rate_hz == pytest.approx(396e6 / 20 / worst_tick(kind))


def test_the_table_of_the_laws_costs_is_the_one_in_use():
    text = (firmware_folder() / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([A-Za-z-]+)[^|]* \| (\d{3,}) \|$", text, re.M)
    names = {"PI": "pi", "notch": "notch_pi", "filtered": "filtered_pi", "limit-observer": "limit_observer"}
    assert {names.get(name, name): int(instructions) for name, instructions in rows} == WORST_TICK


@pytest.fixture
def built(monkeypatch, tmp_path):
    """Return a function that builds an image which takes no time, whose ticks take so many instructions."""
    made = image.Image(*(tmp_path / f"made.{kind}" for kind in ("elf", "hex", "map")), 12_345, 6789)
    monkeypatch.setattr(image, "build", lambda *_, **__: made)
    gains = {"controller.kind": "pi", "controller.kp": 0.06, "controller.ki": 134.0}

    def build(tick=1000, **more):
        counted = budget.Instructions(tick=tick, law=100, effect=tick + 200, interrupts=300, background=400)
        monkeypatch.setattr(budget, "traced", lambda _: counted)
        return fl.firmware.build(fl.bench().evolve(gains), tmp_path / "image", trace=fl.device.instructions, **more)

    return build


def test_the_instructions_are_those_of_the_image_that_was_built(built):
    pytest.importorskip("unicorn")
    found = built()
    assert found.worst_tick_instructions == 1200 and found.highest_rate_hz == pytest.approx(16500.0)
    assert found.table("instructions").loc["at most"].tolist() == [1000, 100, 1200, 300, 400]
    assert "TICK-LATE" not in [each.code for each in found.findings]


def test_a_rate_that_ticks_may_not_keep_is_found_and_one_that_they_cannot_is_refused(built):
    pytest.importorskip("unicorn")
    (late,) = (each for each in built(tick=5000).findings if each.code == "TICK-LATE")
    assert (late.value, late.limit) == (5000.0, highest_rate_hz(5200)) and late.more["instructions"] == 5200
    most = int(BEYOND * highest_rate_hz(1) / 5000)
    assert built(tick=most - 200).worst_tick_instructions == most
    with pytest.raises(fl.FrictionloopError, match=r"controller.rate_hz = 5000 Hz: must be at most 4999") as refused:
        built(tick=most - 198)
    assert refused.value.code == "TICK-LATE"


def test_an_image_in_numbers(built, tmp_path):
    said = built(board="mps2").to_dict()
    assert (said["board"], said["flash_bytes"], said["ram_bytes"]) == ("mps2", 12_345, 6789)
    assert (said["hex"], said["folder"], said["instructions"]) == (
        str(tmp_path / "made.hex"),
        str(tmp_path / "image"),
        None,
    )


@pytest.mark.slow
def test_an_image_fits(frictionloop, tmp_path):
    pytest.importorskip("ziglang")
    said = json.loads(frictionloop("firmware", "build", *PI, "--out", str(tmp_path / "image"), "--json").out)
    lines = (tmp_path / "image" / "teensy41.hex").read_text().splitlines()
    assert lines[-1] == ":00000001FF" and all(line.startswith(":") for line in lines)
    assert said["flash_bytes"] <= 64 * 1024 and said["hex"].endswith("teensy41.hex")


@pytest.mark.slow
def test_the_image_carries_the_values_that_build_says(frictionloop, tmp_path):
    pytest.importorskip("ziglang")
    pytest.importorskip("unicorn")
    folder, arguments = tmp_path / "image", (*PI, "--board", "teensy41", "--json")
    built = json.loads(frictionloop("firmware", "build", *arguments, "--out", str(folder)).out)
    exported = json.loads(frictionloop("firmware", "export", *PI, "--out", str(tmp_path / "table"), "--json").out)
    told = json.loads(frictionloop("device", "info", f"emulated:{folder}", str(folder / "system.toml"), "--json").out)
    assert told["values"] == built["values"] == exported["values"] != built["layout"]
    assert (told["layout"], told["differing"]) == (built["layout"], [])
    assert (folder / "values.txt").read_text() == f"values {told['values']}\n"
