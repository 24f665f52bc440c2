"""``frictionloop firmware``: the table as files, the image, and what is refused."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.cost import WORST_TICK, worst_tick
from frictionloop.device.emulator import budget
from frictionloop.device.emulator.trace import Spent
from frictionloop.firmware import image
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
    shown = frictionloop("firmware", "export", *PI, "--out", str(folder)).out
    assert f"{word_count()}, layout {said['layout']}, values {said['values']}" in shown
    assert said["stable"] and "RINGS" not in shown
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


@pytest.mark.parametrize(
    ("ceiling_um", "said"),
    [
        (0.3, "for a first run: NO force asked for, 0.5 to 0.6 N, is reached on the file's finger just landed"),
        (1.1, "for a first run: not every force asked for, 0.5 to 0.6 N, is reached"),
        (2.0, ""),
    ],
)
def test_a_ceiling_says_which_forces_it_leaves_out(frictionloop, tmp_path, ceiling_um, said):
    forces = ("--setpoint.offset_n", "0.55", "--setpoint.amplitude_n", "0.05", "--board.ceiling_um", str(ceiling_um))
    shown = " ".join(frictionloop("firmware", "export", *PI, *forces, "--out", str(tmp_path / "table")).out.split())
    assert f"ceiling {ceiling_um:g} um, board.ceiling_um" in shown and said in shown
    assert ("for a first run" in shown) is bool(said)
    bench = fl.bench().friction
    least_n = float(bench.nominal_n * np.exp(-bench.susceptibility_per_um2 * ceiling_um**2))
    assert (least_n > 0.5) is bool(said) and (f"which has {least_n:.3g} N there" in shown) is bool(said)


def test_gains_that_ring_on_the_bench_are_told_before_they_are_flashed(frictionloop, tmp_path):
    printed = ("firmware", "export", "--preset", "bench", "--controller.kp", "10", "--out", str(tmp_path / "table"))
    assert not json.loads(frictionloop(*printed, "--json").out)["stable"]
    said = " ".join(frictionloop(*printed).out.split())
    assert "RINGS these gains are unstable on this bench: not for a finger" in said
    # In open loop nothing rings.
    opened = json.loads(frictionloop(*printed[:4], "--controller.kind", "lookup", *printed[-2:], "--json").out)
    assert opened["stable"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--preset", "bench", "--controller.rate_hz", "10000"), "controller.rate_hz = 10000 Hz"),
        (("--preset", "bench", "--controller.kind", "pi", "--controller.kp", "1e12"), "kp"),
    ],
)
def test_what_the_firmware_cannot_do_is_one_line_and_no_file(frictionloop, tmp_path, arguments, says):
    folder = tmp_path / "table"
    refused = frictionloop("firmware", "export", *arguments, "--out", str(folder))
    assert refused.code == 2 and says in refused.err and refused.err.count("\n") == 1
    assert not folder.exists()


def test_a_folder_that_is_a_file_is_refused(frictionloop, tmp_path):
    (tmp_path / "table").write_text("mine")
    refused = frictionloop("firmware", "export", *PI, "--out", str(tmp_path / "table"))
    assert refused.code == 2 and "must be a folder" in refused.err
    assert (tmp_path / "table").read_text() == "mine"


def test_an_unknown_board_is_refused_before_anything_is_written(frictionloop, tmp_path):
    refused = frictionloop("firmware", "build", *PI, "--board", "uno", "--out", str(tmp_path / "image"))
    assert refused.code == 2 and "teensy31" in refused.err and not (tmp_path / "image").exists()


def test_help_lists_every_board(frictionloop, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    out = frictionloop("firmware", "build", "--help").out
    (line,) = (line for line in out.splitlines() if "--board" in line and "qemu" in line)
    assert set(BOARDS) <= set(re.findall(r"[\w-]+", line))


@pytest.mark.parametrize("kind", ["pi", "filtered_pi", "lookup"])
def test_the_cost_is_the_one_that_was_traced(frictionloop, tmp_path, kind):
    arguments = ("firmware", "export", "--preset", "bench", "--controller.kind", kind, "--out", tmp_path / "table")
    said = json.loads(frictionloop(*arguments, "--json").out)
    assert said["worst_tick_cycles"] == worst_tick(kind).cycles and said["tick_cycles"] == 72_000_000 // 5000
    traced = "traced on a reference image with two force axes, not on this one, in an emulator"
    words = f"worst tick {worst_tick(kind).cycles:,} of 14,400 cycles, {traced}"
    assert words in " ".join(frictionloop(*arguments).out.split())


def test_the_table_of_the_laws_costs_is_the_one_in_use():
    text = (firmware_folder() / "README.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([A-Za-z-]+)[^|]* \| (\d+) \| (\d+) \|$", text, re.M)
    names = {"PI": "pi", "notch": "notch_pi", "filtered": "filtered_pi", "limit-observer": "limit_observer"}
    told = {names.get(name, name): (int(instructions), int(cycles)) for name, instructions, cycles in rows}
    assert told == WORST_TICK


def said_by_build(frictionloop, monkeypatch, tmp_path, *arguments):
    """Return what `build` says of an image that took no time."""
    made = image.Image(*(tmp_path / f"made.{kind}" for kind in ("elf", "hex", "map")), 12_345, 6789)
    monkeypatch.setattr(image, "build", lambda *_, **__: made)
    part = [Spent(100, 1000, 10, 20, 30, 40, 50)]
    monkeypatch.setattr(budget, "traced", lambda _: budget.Budget(part, part, part, part, part, part))
    return frictionloop("firmware", "build", *PI, *arguments, "--out", tmp_path / "image").out


def test_an_image_of_the_teensy_is_to_be_flashed_and_others_are_not(frictionloop, monkeypatch, tmp_path):
    teensy = said_by_build(frictionloop, monkeypatch, tmp_path)
    assert "to be flashed" in teensy and "12,345 of 262,144 bytes" in teensy and "6,789 of 65,536 bytes" in teensy
    other = said_by_build(frictionloop, monkeypatch, tmp_path, "--board", "mps2")
    assert "flashed" not in other and "262,144" not in other and "12,345 bytes" in other


def test_the_cycles_are_those_of_the_image_that_was_built(frictionloop, monkeypatch, tmp_path):
    pytest.importorskip("unicorn")
    said = " ".join(said_by_build(frictionloop, monkeypatch, tmp_path).split())
    assert "worst tick 1,470 of 14,400 cycles, traced on this image" in said
    assert "as assumed 1,470 1,470 1,470 4,410" in said
    assert "RAM waits a cycle a word 1,510" in said
    assert "1,470 cycles at most, MORE than the 10 us that make a tick late" in said
    numbers = json.loads(said_by_build(frictionloop, monkeypatch, tmp_path, "--json"))["cycles"]["as assumed"]
    assert numbers["sum"] == 3 * numbers["tick"] == 4410


def test_an_image_in_numbers(frictionloop, monkeypatch, tmp_path):
    said = json.loads(said_by_build(frictionloop, monkeypatch, tmp_path, "--board", "mps2", "--json"))
    assert (said["board"], said["flash_bytes"], said["ram_bytes"]) == ("mps2", 12_345, 6789)
    assert said["hex"] == str(tmp_path / "made.hex") and said["table"] == str(tmp_path / "image")


@pytest.mark.slow
def test_an_image_fits(frictionloop, tmp_path):
    pytest.importorskip("ziglang")
    said = json.loads(frictionloop("firmware", "build", *PI, "--out", str(tmp_path / "image"), "--json").out)
    lines = (tmp_path / "image" / "teensy31.hex").read_text().splitlines()
    assert lines[-1] == ":00000001FF" and all(line.startswith(":") for line in lines)
    assert said["flash_bytes"] <= 32 * 1024 and said["hex"].endswith("teensy31.hex")


@pytest.mark.slow
def test_the_image_carries_the_values_that_build_says(frictionloop, tmp_path):
    pytest.importorskip("ziglang")
    pytest.importorskip("unicorn")
    folder, arguments = tmp_path / "image", (*PI, "--board", "teensy31", "--json")
    built = json.loads(frictionloop("firmware", "build", *arguments, "--out", str(folder)).out)
    exported = json.loads(frictionloop("firmware", "export", *PI, "--out", str(tmp_path / "table"), "--json").out)
    told = json.loads(frictionloop("device", "info", f"emulated:{folder}", str(folder / "system.toml"), "--json").out)
    assert told["values"] == built["values"] == exported["values"] != built["layout"]
    assert (told["layout"], told["differing"]) == (built["layout"], [])
    assert (folder / "values.txt").read_text() == f"values {told['values']}\n"
