"""``frictionloop firmware``: the table as files, the image, and what is refused."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.cost import BUDGET_CYCLES, LATE_CYCLES, WORST_TICK, worst_tick
from frictionloop.device.emulator import budget
from frictionloop.device.emulator.trace import Spent
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
    words = np.frombuffer((folder / "parameters.bin").read_bytes(), "<i4")
    assert said["law"] == "pi" and len(words) == word_count() == said["words"]
    assert "table_hash" not in said
    assert said["stable"] and "LOOP-UNSTABLE" not in [each["code"] for each in said["findings"]]
    assert said["clamp_n"] == [fl.bench().controller.model.floor_n, fl.bench().controller.model.nominal_n]
    with (folder / "parameters.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    raw = [int(number) for row in rows for number in row["raw"].split()]
    assert np.array_equal(raw, words)
    value = {row["name"]: float(row["value"]) for row in rows}
    model = fl.bench().controller.model
    assert value["law.high_n"] == pytest.approx(model.nominal_n, abs=2**-28)
    assert value["law.gains[0]"] == pytest.approx(0.06, rel=1e-9)
    assert value["law.gains[1]"] == pytest.approx(134 / 5000, rel=1e-9)
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
def test_the_cost_is_the_one_that_was_traced(tmp_path, kind):
    found = fl.firmware.export(fl.bench().evolve({"controller.kind": kind}), tmp_path / "table")
    assert found.worst_tick_cycles == worst_tick(kind).cycles and found.tick_cycles == 72_000_000 // 5000


def test_the_table_of_the_laws_costs_is_the_one_in_use():
    text = (firmware_folder() / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([A-Za-z-]+)[^|]* \| (\d+) \| (\d+) \|$", text, re.M)
    names = {"PI": "pi", "notch": "notch_pi", "filtered": "filtered_pi", "limit-observer": "limit_observer"}
    told = {names.get(name, name): (int(instructions), int(cycles)) for name, instructions, cycles in rows}
    assert told == WORST_TICK


@pytest.fixture
def built(monkeypatch, tmp_path):
    """Return a function that builds an image which takes no time."""
    made = image.Image(*(tmp_path / f"made.{kind}" for kind in ("elf", "hex", "map")), 12_345, 6789)
    monkeypatch.setattr(image, "build", lambda *_, **__: made)
    part = [Spent(100, 1000, 10, 20, 30, 40, 50)]
    monkeypatch.setattr(budget, "traced", lambda _: budget.Budget(part, part, part, part, part, part))
    gains = {"controller.kind": "pi", "controller.kp": 0.06, "controller.ki": 134.0}

    def build(**more):
        return fl.firmware.build(fl.bench().evolve(gains), tmp_path / "image", trace=fl.device.cycles, **more)

    return build


def test_the_cycles_are_those_of_the_image_that_was_built(built):
    pytest.importorskip("unicorn")
    found = built()
    assert found.worst_tick_cycles == 1470 and found.cycles["RAM waits a cycle"]["tick"] == 1510
    assert found.cycles["as assumed"]["sum"] == 3 * found.cycles["as assumed"]["tick"] == 4410
    assert found.table("cycles").loc["as assumed"].tolist() == [1470, 1470, 1470, 4410]
    (late,) = (each for each in found.findings if each.code == "TICK-LATE")  # behind the port
    assert (late.value, late.limit) == (1470, LATE_CYCLES)


def test_a_tick_that_takes_more_than_there_is_is_found(built):
    row = {"background": 10, "effect": 1, "flood": 1, "longest_interrupt": 100}
    over = {"as assumed": row | {"tick": 1000, "interrupts": 100, "sum": 1110},
            "RAM waits": row | {"tick": BUDGET_CYCLES, "interrupts": 100, "sum": BUDGET_CYCLES + 110}}  # fmt: skip
    (late,) = exported._late(over)
    assert (late.code, late.value, late.limit) == ("TICK-LATE", BUDGET_CYCLES + 100, BUDGET_CYCLES)
    assert "RAM waits" in late.more["waits"] and [*exported._late({"as assumed": over["as assumed"]})] == []


def test_an_image_in_numbers(built, tmp_path):
    said = built(board="mps2").to_dict()
    assert (said["board"], said["flash_bytes"], said["ram_bytes"]) == ("mps2", 12_345, 6789)
    assert (said["hex"], said["folder"], said["cycles"]) == (str(tmp_path / "made.hex"), str(tmp_path / "image"), None)


@pytest.mark.slow
def test_an_image_fits(frictionloop, tmp_path):
    pytest.importorskip("ziglang")
    said = json.loads(frictionloop("firmware", "build", *PI, "--out", str(tmp_path / "image"), "--json").out)
    lines = (tmp_path / "image" / "teensy41.hex").read_text().splitlines()
    assert lines[-1] == ":00000001FF" and all(line.startswith(":") for line in lines)
    assert said["flash_bytes"] <= 32 * 1024 and said["hex"].endswith("teensy41.hex")


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
