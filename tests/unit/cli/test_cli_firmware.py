"""``frictionloop firmware``: the table as files, the image, and what is refused."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.quantities.schema import parameter_words, word_count

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
    assert said["law"] == "pi" and len(words) == word_count()
    with (folder / "parameters.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    raw = [int(number) for row in rows for number in row["raw"].split()]
    assert np.array_equal(raw, words)
    value = {row["name"]: float(row["value"]) for row in rows}
    model = fl.bench().controller.model
    assert value["law.high_n"] == pytest.approx(model.nominal_n, abs=2**-28)
    assert value["law.gains[0]"] == pytest.approx(0.06, rel=1e-9)
    assert value["law.gains[1]"] == pytest.approx(134 / 5000, rel=1e-9)
    assert value["drive.duty[256]"] == 2**16  # half of the carrier's period
    assert {row["name"].split("[")[0] for row in rows} == set(parameter_words())
    assert fl.read_toml(folder / "system.toml").controller.ki == 134


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--preset", "bench", "--controller.kind", "oracle"), "oracle"),
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


@pytest.mark.slow
def test_an_image_fits(frictionloop, tmp_path):
    pytest.importorskip("ziglang")
    said = json.loads(frictionloop("firmware", "build", *PI, "--out", str(tmp_path / "image"), "--json").out)
    lines = (tmp_path / "image" / "teensy31.hex").read_text().splitlines()
    assert lines[-1] == ":00000001FF" and all(line.startswith(":") for line in lines)
    assert int(said["flash"].split()[0].replace(",", "")) <= 32 * 1024
