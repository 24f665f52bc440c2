"""``frictionloop simulate``: the same run as in Python, said on a screen, as JSON and in files."""

from __future__ import annotations

import errno
import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.cli.flags import gather, overrides_of, scalar

SHORT = ("simulate", "--preset", "feasible", "--duration-s", "0.2")


def test_json_holds_the_diagnosis_of_the_same_run_in_python(frictionloop):
    answer = frictionloop(*SHORT, "--controller.kp", "12", "--seed", "3", "--split-hz", "8", "--json").json()
    system = fl.feasible().evolve({"controller.kp": 12})
    found = fl.diagnose(fl.simulate(system, 0.2, seed=3), split_hz=[8.0])
    saved = {"saved": {}}
    assert answer == json.loads(found.to_json()) | saved
    assert fl.System.from_tree(answer["system"]) == system
    late = frictionloop(*SHORT, "--score-from-s", "0.1", "--json").json()
    assert late["rms_error_n"] == fl.diagnose(fl.simulate(fl.feasible(), 0.2), 0.1).rms_error_n


def test_json_has_no_nan_for_a_constant_set_point(frictionloop):
    answer = frictionloop(*SHORT, "--setpoint.kind", "constant", "--setpoint.offset_n", "0.5", "--json").json()
    assert answer["r2_identity"] is None
    assert answer["rms_error_n"] > 0
    told = frictionloop(*SHORT, "--setpoint.kind", "constant").out
    assert "R2" not in told and "nan" not in re.findall(r"\w+", told)


def test_order_of_flags_does_not_matter_for_a_kind(frictionloop):
    flags = ("--setpoint.frequency_hz", "5", "--setpoint.kind", "sine", "--setpoint.offset_n", "0.6", "--json")
    answer = frictionloop(*SHORT, *flags).json()
    assert answer["system"]["setpoint"] == {"kind": "sine", "offset_n": 0.6, "amplitude_n": 0, "frequency_hz": 5}
    (left,) = (each for each in answer["findings"] if each["code"] == "KIND-DEFAULTS")
    assert left["remedy"] == {"setpoint.amplitude_n": 0.18}


def test_lists_are_toml(frictionloop):
    flags = ("--setpoint.kind", "steps", "--setpoint.times_s", "[0, 0.1]", "--setpoint.levels_n", "[0.4, 0.6]")
    assert frictionloop(*SHORT, *flags, "--json").json()["system"]["setpoint"]["levels_n"] == [0.4, 0.6]


def test_recording_as_disturbance(frictionloop):
    Path("d.csv").write_text("force\n" + "\n".join(f"{0.1 + 0.001 * k}" for k in range(100)))
    flags = (
        "--disturbance.kind",
        "recording",
        "--disturbance.path",
        "d.csv",
        "--disturbance.column",
        "force",
        "--disturbance.offset_n",
        "0",
    )
    answer = frictionloop(
        "simulate", "--duration-s", "0.05", *flags, "--disturbance.rate_hz", "1000", "--out", "run.h5"
    )
    assert (answer.code, answer.err) == (0, "")
    assert fl.load("run.h5").d.values[[0, -1]] == pytest.approx([0.1, 0.1498], abs=1e-4)


def test_saved_files_can_be_used(frictionloop):
    answer = frictionloop(*SHORT, "--out", "run.h5", "--plot", "run.svg", "--save-system", "bench.toml")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.endswith("saved run: run.h5\nsaved plot: run.svg\nsaved system: bench.toml\n")
    assert fl.load("run.h5").identical(fl.simulate(fl.feasible(), 0.2))
    assert Path("run.svg").read_text().startswith("<?xml")
    assert fl.read_toml("bench.toml") == fl.feasible()
    again = frictionloop("simulate", "bench.toml", "--duration-s", "0.2", "--out", "again.h5")
    assert again.code == 0
    assert fl.load("again.h5").identical(fl.load("run.h5"))


def test_a_saved_run_counts_what_its_command_counted(frictionloop):
    answer = frictionloop(*SHORT, "--score-from-s", "0.1", "--out", "late.h5", "--json").json()
    assert fl.load("late.h5").scored.attrs == fl.simulate(fl.bench(), 0.2).scored.attrs
    assert fl.metrics(fl.load("late.h5"))["rms_error"] == answer["rms_error_n"]
    assert fl.metrics(fl.simulate(fl.feasible(), 0.2))["rms_error"] != answer["rms_error_n"]


@pytest.mark.parametrize("ending", ["png", "pdf"])
def test_plot_in_other_formats(frictionloop, ending):
    assert frictionloop(*SHORT, "--plot", f"run.{ending}").code == 0
    assert Path(f"run.{ending}").stat().st_size > 5000


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12),
        ("1e-5", 1e-5),
        ("-0.5", -0.5),
        ("true", True),
        ("sine", "sine"),
        ('"2"', "2"),
        ("[1, 2.5]", [1, 2.5]),
        ("1,2.5", [1, 2.5]),
        ("0, -1e-3", [0, -1e-3]),
        ("run,2.csv", "run,2.csv"),
        (",", ","),
        (".5", ".5"),  # not TOML; validation reads it as a number
        ("2026-01-01", "2026-01-01"),
        ("1\ny = 2", "1\ny = 2"),
        ("", ""),
    ],
)
def test_scalar(text, value):
    assert scalar(text) == value
    assert type(scalar(text)) is type(value)


@given(st.floats(allow_nan=False))
def test_scalar_reads_every_float_back(value):
    assert scalar(repr(value)) == value


def test_gather_rewrites_dotted_flags_only():
    tokens = ["simulate", "a.b.toml", "--controller.kp", "-1", "--x.y-z=2", "--out=./run.h5", "--", "--controller.ki"]
    assert gather(tokens) == [
        "simulate",
        "a.b.toml",
        "--BLOCK.NAME=controller.kp=-1",
        "--BLOCK.NAME=x.y_z=2",
        "--out=./run.h5",
        "--",
        "--controller.ki",
    ]
    assert overrides_of(["a.b=1", "a.kind=sine"]) == {"a.kind": "sine", "a.b": 1}
    assert list(overrides_of(["a.b=1", "a.kind=sine"])) == ["a.kind", "a.b"]
    assert np.isnan(overrides_of(["a.b=nan"])["a.b"])


def test_a_saved_system_is_short_and_all_of_it_on_request(frictionloop):
    short = ("simulate", "--preset", "bench", "--duration-s", "0.01", "--save-system")
    assert frictionloop(*short, "short.toml").code == frictionloop(*short, "whole.toml", "--whole").code == 0
    texts = [Path(name).read_text(encoding="utf-8") for name in ("short.toml", "whole.toml")]
    assert ["[board]" in text for text in texts] == [False, True]
    assert "kp = 10.0  # N/N: Proportional gain K_p" in texts[0]
    assert fl.read_toml("short.toml") == fl.read_toml("whole.toml") == fl.bench()


@pytest.fixture
def with_a_mean(tmp_path):
    rows = "".join(f"{k / 1000:.3f},{600 + 50 * (k % 2)}\n" for k in range(500))
    (tmp_path / "slide.csv").write_text("Time (s),Ft [mN]\n" + rows)
    return ("--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "slide.csv"))


@pytest.mark.parametrize("column", ["Ft", "Ft [mN]", '"Ft [mN]"', "ft (mN)", "Ft mN"])
def test_a_column_is_found_as_people_copy_it(frictionloop, with_a_mean, column):
    flags = ("--preset", "feasible", *with_a_mean, "--disturbance.column", column, "--duration-s", "0.1")
    read = frictionloop("simulate", *flags, "--json").json()["recorded"]["disturbance"]
    assert (read["unit"], read["unit_by"], read["samples"]) == ("mN", "file", 500)


def test_a_path_without_a_kind_names_the_flag(frictionloop):
    said = frictionloop("simulate", "--preset", "feasible", "--disturbance.path", "slide.csv").err
    assert "give that too, as --disturbance.kind recording" in said


def test_a_recording_too_short_names_the_flag_and_the_longest(frictionloop, with_a_mean):
    flags = ("simulate", "--preset", "feasible", *with_a_mean, "--disturbance.column", "Ft", "--duration-s")
    assert frictionloop(*flags, "0.5").code == 0  # 500 samples at 1 kHz, the last held for a millisecond
    assert "duration_s must be at most 0.5 s" in frictionloop(*flags, "0.6").err


@pytest.fixture
def sliding(tmp_path):
    """Return the flags of a recording of 2 s whose mean over the first second is not that of all of it."""
    rows = "".join(f"{k / 1000:.3f},{0.5 + 0.02 * (k >= 1000) + 0.01 * (k % 20 < 10):.3f}\n" for k in range(2000))
    (tmp_path / "slide.csv").write_text("time_s,force_n\n" + rows)
    return ("--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "slide.csv"))


def test_a_column_of_times_that_nobody_asked_for_is_said_to_be_the_default(frictionloop, sliding):
    said = frictionloop("simulate", "--preset", "feasible", *sliding, "--duration-s", "1").err
    assert "--disturbance.column and --setpoint.column) holds times; accepted: 'force'" in said


def test_a_recording_is_read_once(frictionloop, sliding, monkeypatch):
    from frictionloop.recordings import file_opening

    reads, reader = [], file_opening.READERS[".csv"]
    counted = {**file_opening.READERS, ".csv": lambda path, **more: reads.append(path) or reader(path, **more)}
    monkeypatch.setattr(file_opening, "READERS", counted)
    frictionloop("simulate", "--preset", "feasible", *sliding, "--disturbance.column", "1", "--duration-s", "0.1")
    assert len(reads) == 1


@pytest.mark.parametrize("verb", [("simulate",), ("sweep", "--over", "controller.kp=5,9")])
def test_the_command_line_has_a_doubt_once_and_no_warning(frictionloop, with_a_mean, verb):
    level = ("--setpoint.kind", "constant", "--setpoint.offset_n", "0.5", "--duration-s", "0.1")
    answer = frictionloop(*verb, "--preset", "feasible", *level, *with_a_mean, "--disturbance.column", "Ft")
    said = answer.out + answer.err
    assert said.count("MEAN-DOUBT") == 1 and "evolve(" not in said and "Warning" not in said


def test_a_system_that_is_not_designed_for_costs_no_design(frictionloop, monkeypatch):
    from frictionloop.design import controller_design

    monkeypatch.delattr(controller_design, "controller")
    assert frictionloop("simulate", "--preset", "bench", "--duration-s", "0.5").code == 0


@pytest.mark.parametrize("option", ["--out=run.h5", "--plot=run.svg"])
def test_full_disk_leaves_the_old_file(frictionloop, monkeypatch, option):
    target = Path(option.partition("=")[2])
    frictionloop("simulate", "--duration-s", "0.01", option)
    old = target.read_bytes()

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    for name in ("write_bytes", "write_text"):
        monkeypatch.setattr(Path, name, full)
    answer = frictionloop("simulate", "--duration-s", "0.01", option)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err == f"error: {target}: cannot be written (No space left on device); the old file is untouched\n"
    assert target.read_bytes() == old
    assert [path.name for path in Path().iterdir()] == [target.name]
