"""``frictionloop compare``: the numbers that Python gives, one line for what is wrong, nothing lost on Ctrl-C."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli import screen
from frictionloop.design import comparison as rooms
from frictionloop.design import synthesis
from frictionloop.design.comparison import run
from frictionloop.design.comparison.table import MARGINS

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
    return rooms.compare(fl.bench(), 2, 0, ["lookup", "retuned_pi"], [20.0], duration_s=1.6, progress=False)


@pytest.mark.slow
def test_json_and_csv_hold_the_numbers_of_python(frictionloop, ran):
    found = frictionloop(*WORDS, "--json", "--csv", "s.csv").json()
    rows = rooms.score_rows(rooms.scores(ran))
    assert len(found["scores"]) == len(rows)
    for got, wanted in zip(found["scores"], rows, strict=True):
        for name, value in wanted.items():
            if isinstance(value, float) and not abs(value) < float("inf"):
                assert got[name] is None
            else:
                assert got[name] == value
    assert found["laws"]["retuned_pi"] == {"controller.kind": "pi", **fl.RETUNED}
    assert (found["seed"], found["fingers"]) == (0, 2)
    with open("s.csv", newline="") as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == len(rows) + len(MARGINS) * len(found["margins"])
    first = next(row for row in table if row["score"] == "residual_rms_n" and row["population"] == "all")
    assert float(first["median"]) == next(
        row["median"] for row in rows if row["score"] == "residual_rms_n" and row["population"] == "all"
    )
    assert {row["score"] for row in table} >= {"sensitivity_peak", "delay_margin_s", "relative_index"}


@pytest.mark.slow
def test_a_recorded_set_point_gives_way_to_the_protocols_and_that_is_said(frictionloop, tmp_path, ran):
    time_s = np.arange(200) / 100
    np.savetxt(
        "wanted.csv", np.c_[time_s, 0.6 + 0.1 * np.sin(9 * time_s)], delimiter=",", header="time_s,force_n", comments=""
    )
    Path("r.toml").write_text(
        'schema = 1\npreset = "bench"\n[setpoint]\nkind = "recording"\npath = "wanted.csv"\ncolumn = "force_n"\n'
    )
    answer = frictionloop(WORDS[0], "r.toml", *WORDS[1:], "--json")
    assert "compared on the protocol's own forces;" in " ".join(answer.noted)
    rows = zip(json.loads(answer.out)["scores"], rooms.score_rows(rooms.scores(ran)), strict=True)
    pairs = [
        (got["median"], wanted["median"])
        for got, wanted in rows
        if got["law"] == "lookup" and np.isfinite(wanted["median"])
    ]
    assert len(pairs) > 20 and all(got == wanted for got, wanted in pairs)


@pytest.mark.slow
def test_summary_files_and_figures(frictionloop, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    answer = frictionloop(*WORDS, "--out", "r.h5", "--plots", "figures")
    assert (answer.code, answer.noted) == (0, [])
    assert "20 mm/s, slip length 11.5 um: median / worst decile of" in answer.out
    assert "20 mm/s, slip length 0 um: median / worst decile of" in answer.out
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= 100
    assert "saved results as r.h5" in answer.out
    assert fl.load(tmp_path / "r.h5").attrs["kind"] == "comparison"
    drawn = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert {"residuals.svg", "residuals.png"} <= set(drawn)
    begins = {".svg": b"<?xml", ".png": b"\x89PNG"}
    content = {name: (tmp_path / "figures" / name).read_bytes() for name in drawn}
    assert all(content[name].startswith(begins[name[-4:]]) for name in drawn)
    refused = frictionloop(*WORDS, "--out", "r.h5")
    assert (refused.code, refused.err) == (
        2,
        "error: r.h5: exists; add --resume (resume=True) to continue it, delete it, or choose another file\n",
    )
    again = frictionloop(*WORDS, "--out", "r.h5", "--resume")
    tables = [text[text.index("20 mm/s") : text.index("saved")] for text in (answer.out, again.out)]
    assert tables[0] == tables[1]


def test_the_time_it_takes_is_said_before_it_begins(frictionloop, monkeypatch, ran):
    def begun(*_, begin, **__):
        begin(["hinf"] * 4 + ["retuned_pi"] * 156)
        return ran

    monkeypatch.setattr(rooms, "compare", begun)
    words = ("compare", "--fingers", "1000", "--duration-s", "10", "--jobs", "2")
    said = "160 cells to run: about 5 min with 2 workers, of that 15 s to design laws\n"
    assert frictionloop(*words).err == said
    assert frictionloop("compare", "--fingers", "0").err.count("\n") == 1


@pytest.mark.parametrize(
    ("time_s", "text"), [(7.2, "7 s"), (47, "50 s"), (100, "2 min"), (1900, "30 min"), (9000, "2 h")]
)
def test_a_time_that_is_estimated_is_round(time_s, text):
    assert screen.about(time_s) == text


def test_interrupted_says_how_to_go_on(frictionloop, monkeypatch):
    really = run._Trial.run

    def stopping(self, law, at):
        if at.task == "hold 0.4":
            raise KeyboardInterrupt
        return really(self, law, at)

    monkeypatch.setattr(run._Trial, "run", stopping)
    answer = frictionloop(*WORDS, "--out", "r.h5")
    assert answer.code == 130
    assert "interrupted: 9 of 38 cells done, kept in r.h5" in answer.err
    assert answer.err.rstrip().endswith("--resume")
    assert "not kept" in frictionloop(*WORDS).err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--laws", "retunedpi"), "error: laws: 'retunedpi' is unknown; did you mean retuned_pi"),
        (("--seed", "3"), "error: seed = 3: is that of the fingers laws are tuned on"),
        (("--speeds", "fast"), "error: speeds = 'fast': must be numbers"),
        (("--speeds", "0"), "error: speeds = 0 mm/s: must be from 2 to 500"),
        (("--speeds", "20,1.9"), "error: speeds = 1.9 mm/s: must be from 2 to 500"),
        (("--speeds", "501"), "error: speeds = 501 mm/s: must be from 2 to 500"),
        (("--speeds", "nan"), "error: speeds = nan mm/s: must be from 2 to 500"),
        # Turning round takes 0.625 x 2 s of a stroke of 240 mm: 192 mm/s leave nothing of it.
        (("--speeds", "193", "--motion.reversal_s", "2"), "error: speeds = 193 mm/s: must be from 2 to 192"),
        (("--speeds", "20,20"), "error: speeds = [20.0, 20.0] mm/s: must name"),
        (("--duration-s", "1"), "error: duration_s = 1 s: must be longer than 1 s, the part"),
        (("--duration-s", "inf"), "error: duration_s = inf s: must be longer than 1 s, the part"),
        (("--duration-s", "1.50001"), "error: duration_s = 1.50001 s is not a whole number"),
        (("--fingers", "0"), "error: fingers = 0: must be a whole number"),
        (("--out", "nowhere/r.h5"), "error: --out = 'nowhere/r.h5': there is no folder"),
        (("--out", "r.txt"), "error: --out = 'r.txt': must end in"),
        (("--plots", "nowhere/figures"), "error: --plots = 'nowhere/figures': must be a folder"),
        (("--resume",), "error: resume: needs --out"),
        (("--preset", "paper"), 'error: friction.kind = "gaussian": must be "finger"'),
        (("--friction.nominal_n", "0.8"), "error: friction.nominal_n: every finger of a comparison brings its own"),
        (("--setpoint.kind", "sine"), "error: setpoint.kind: the protocol of a comparison sets it"),
        (("--controller.kp", "1"), "error: controller.kp: every law of a comparison brings its own"),
        (("missing.toml",), "error: missing.toml: cannot be read"),
    ],
    ids=str,
)
def test_what_is_wrong_is_said_in_one_line_before_any_law_is_designed(frictionloop, monkeypatch, words, said):
    def designed(*_):
        raise AssertionError("a law was designed")

    monkeypatch.setattr(synthesis, "design_controller", designed)
    answer = frictionloop("compare", *words)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith(said)
    assert answer.err.count("\n") == 1
