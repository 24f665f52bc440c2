"""``frictionloop compare``: the numbers that Python gives, one line for what is wrong, nothing lost on Ctrl-C."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli import screen
from frictionloop.design import controller_synthesis
from frictionloop.design.comparison import comparison_run
from frictionloop.design.comparison.comparison_run import about_s
from frictionloop.design.comparison.law_margins import MARGINS

WORDS = (
    "compare",
    "--fingers",
    "2",
    "--seed",
    "0",
    "--duration-s",
    "1.6",
    "--speeds",
    "20",
    "--laws",
    "lookup,retuned_pi",
)


@pytest.fixture(scope="module")
def ran():
    return fl.compare(fl.bench(), ["lookup", "retuned_pi"], 2, 0, [20.0], duration_s=1.6, progress=False)


@pytest.mark.slow
def test_json_and_csv_hold_the_numbers_of_python(frictionloop, ran):
    found = frictionloop(*WORDS, "--json", "--csv", "s.csv").json()
    told = json.loads(ran.to_json())
    assert {name: value for name, value in found.items() if name != "saved"} == told
    assert found["laws"]["retuned_pi"] == {"controller.kind": "pi", **fl.RETUNED}
    assert (found["seed"], found["fingers"], found["recommended"]) == (0, 2, None)
    with open("s.csv", newline="") as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == len(ran.scores) + len(MARGINS) * len(ran.margins)
    assert {row["score"] for row in table} >= {"sensitivity_peak", "delay_margin_s", "relative_index"}


@pytest.mark.slow
def test_a_recorded_set_point_gives_way_to_the_protocols_and_that_is_said(frictionloop, ran):
    time_s = np.arange(200) / 100
    rows = np.c_[time_s, 0.6 + 0.1 * np.sin(9 * time_s)]
    np.savetxt("wanted.csv", rows, delimiter=",", header="time_s,force_n", comments="")
    Path("r.toml").write_text(
        'schema = 1\npreset = "bench"\n[setpoint]\nkind = "recording"\npath = "wanted.csv"\ncolumn = "force_n"\n'
    )
    answer = json.loads(frictionloop(WORDS[0], "r.toml", *WORDS[1:], "--json").out)
    assert "OWN-FORCES" in {each["code"] for each in answer["findings"]}
    pairs = [
        (got["median"], wanted["median"])
        for got, wanted in zip(answer["scores"], ran.scores, strict=True)
        if got["law"] == "lookup" and np.isfinite(wanted["median"])
    ]
    assert len(pairs) > 20 and all(got == wanted for got, wanted in pairs)


@pytest.mark.slow
def test_files_and_figures(frictionloop, tmp_path):
    answer = frictionloop(*WORDS, "--out", "r.h5", "--plots", "figures")
    assert (answer.code, answer.noted) == (0, [])
    assert fl.load(tmp_path / "r.h5").attrs["kind"] == "comparison"
    drawn = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert {"residuals.svg", "residuals.png"} <= set(drawn)
    begins = {".svg": b"<?xml", ".png": b"\x89PNG"}
    assert all((tmp_path / "figures" / name).read_bytes().startswith(begins[name[-4:]]) for name in drawn)
    refused = frictionloop(*WORDS, "--out", "r.h5")
    assert (refused.code, refused.err.count("\n")) == (2, 1) and "--resume" in refused.err
    again = frictionloop(*WORDS, "--out", "r.h5", "--resume")
    assert again.out.splitlines()[:-1] == answer.out.splitlines()[:-2]


def test_the_time_it_takes_is_said_before_it_begins(frictionloop, monkeypatch, ran):
    def begun(*_, begin, **__):
        begin(160, about_s(["hinf"] * 4 + ["retuned_pi"] * 156, 5000.0))
        return ran

    monkeypatch.setattr(fl, "compare", begun)
    words = ("compare", "--fingers", "1000", "--duration-s", "10", "--jobs", "2")
    assert frictionloop(*words).err == "160 cells to run: about 4 min\n"
    assert frictionloop("compare", "--fingers", "0").err.count("\n") == 1


def test_a_line_a_law_is_its_worst(ran):
    table = ran.table("laws")
    here = [row for row in ran.scores if row["score"] == "residual_rms_n" and row["population"] == ran.population]
    for law in ran.runs.laws:
        assert table.loc[law, "sines, mN"] == 1e3 * max(row["median"] for row in here if row["law"] == law)
    assert list(table.index) == ["lookup", "retuned_pi"]


@pytest.mark.parametrize(
    ("time_s", "text"), [(7.2, "7 s"), (47, "50 s"), (100, "2 min"), (1900, "30 min"), (9000, "2 h")]
)
def test_a_time_that_is_estimated_is_round(time_s, text):
    assert screen.about(time_s) == text


def test_interrupted_says_how_to_go_on(frictionloop, monkeypatch):
    really = comparison_run._Trial.run

    def stopping(self, law, at):
        if at.task == "hold 0.4":
            raise KeyboardInterrupt
        return really(self, law, at)

    monkeypatch.setattr(comparison_run._Trial, "run", stopping)
    answer = frictionloop(*WORDS, "--out", "r.h5")
    assert answer.code == 130
    assert "interrupted: 9 of 38 cells done, kept in r.h5" in answer.err
    assert answer.err.rstrip().endswith("--resume")
    assert "not kept" in frictionloop(*WORDS).err


@pytest.mark.parametrize("words", ["--laws retunedpi", "--speeds nan", "--plots nowhere/figures", "missing.toml"])
def test_what_is_wrong_is_said_before_any_law_is_designed(frictionloop, monkeypatch, words):
    def designed(*_):
        raise AssertionError("a law was designed")

    monkeypatch.setattr(controller_synthesis, "synthesised", designed)
    assert frictionloop("compare", *words.split()).code == 2
