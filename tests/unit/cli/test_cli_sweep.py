"""``frictionloop sweep``: the same numbers as in Python, best points, and nothing lost on Ctrl-C."""

from __future__ import annotations

import csv
import shlex
import signal
import time
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli.sweep import axes_of

SHORT = ("sweep", "--preset", "feasible", "--duration-s", "0.1")
GRID = (*SHORT, "--over", "controller.kp=1:16:3:log", "--over", "controller.ki=1,2", "--seeds", "2")


def in_python(**more):
    axes = {"controller.kp": [1.0, 4.0, 16.0], "controller.ki": [1, 2]}
    return fl.sweep(fl.feasible(), axes, 0.1, seeds=2, **more)


def test_json_holds_the_same_numbers_as_python(frictionloop):
    answer = frictionloop(*GRID, "--json").json()
    grid = in_python()
    assert answer["dims"] == ["controller.kp", "controller.ki", "seed"]
    assert answer["axes"] == {"controller.kp": [1, 4, 16], "controller.ki": [1, 2]}
    assert list(answer["metrics"]) == ["r2_identity", "rms_error", "saturation_index"]
    for name, values in answer["metrics"].items():
        np.testing.assert_array_equal(values, grid[name])
    mean = grid.rms_error.mean("seed")
    best = mean.where(mean == mean.min(), drop=True)
    assert answer["best"]["rms_error"]["value"] == pytest.approx(float(mean.min()), rel=1e-14)
    assert answer["best"]["rms_error"]["point"] == {axis: best[axis].item() for axis in best.dims}
    assert answer["units"] == {"rms_error": "N"}
    assert (answer["runs_done"], answer["runs"], answer["complete"]) == (12, 12, True)


def test_dotted_flags_change_the_system_that_is_swept(frictionloop):
    answer = frictionloop(*GRID, "--sensor.noise_rms_n", "1e-3", "--metrics", "rms_error", "--json").json()
    assert answer["system"]["sensor"]["noise_rms_n"] == 1e-3
    assert list(answer["metrics"]) == ["rms_error"]


def test_csv_has_one_row_per_run(frictionloop):
    assert frictionloop(*GRID, "--csv", "table.csv").code == 0
    with open("table.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    flat = in_python().stack(run=("controller.kp", "controller.ki", "seed"))
    assert len(rows) == 12
    assert list(rows[0]) == ["controller.kp", "controller.ki", "seed", *flat.data_vars]
    for name in rows[0]:
        assert [float(row[name]) for row in rows] == list(flat[name].values)


def test_axes():
    assert axes_of(["a.b=1,2.5,x"]) == {"a.b": [1, 2.5, "x"]}
    assert axes_of(["a.b-c=0:1:3"]) == {"a.b_c": [0, 0.5, 1]}
    assert axes_of(["a.b=0:1:3:lin"]) == {"a.b": [0, 0.5, 1]}
    assert axes_of(["a.b=1:100:3:log", "a.c=7"]) == {"a.b": [1, 10, 100], "a.c": [7]}
    assert list(axes_of(["b.b=1", "a.a=1"])) == ["b.b", "a.a"]


def interrupt_once_running(running, kept):
    while not kept.exists():
        assert running.poll() is None, running.communicate()
        time.sleep(0.01)
    time.sleep(1.5)  # one tile or more
    running.send_signal(signal.SIGINT)
    return *running.communicate(timeout=60), running.returncode


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done_and_resume_finishes_it(frictionloop, process, tmp_path):
    long = ("--setpoint.sweep_s", "400", "--over", "controller.kp=1:18:64", "--over", "controller.ki=1:10:10:log")
    tokens = ("sweep", "--preset", "feasible", *long, "--duration-s", "400", "--out")
    running = process(*tokens, "kept.h5", "--jobs", "1")
    out, err, code = interrupt_once_running(running, tmp_path / "kept.h5")
    assert code == 130
    *_, said, command = err.splitlines()  # after lines of progress
    done = int(said.split()[1])
    assert 0 < done < 640
    assert said == f"interrupted: {done} of 640 runs done, kept in kept.h5"
    assert f"{done} of 640" in out
    assert int(np.isfinite(fl.load("kept.h5").rms_error).sum()) == done

    assert command.startswith("continue with: python -m frictionloop sweep ")
    assert "unfinished; --resume" in frictionloop(*tokens, "kept.h5").err
    again = shlex.split(command.removeprefix("continue with: python -m frictionloop "))
    assert again == [*tokens, "kept.h5", "--jobs", "1", "--resume"]
    resumed = frictionloop(*again[:-3], "--resume")
    assert (resumed.code, resumed.noted) == (0, [])
    assert "640 of 640" in resumed.out
    assert frictionloop(*tokens, "whole.h5").code == 0
    assert fl.load("kept.h5").identical(fl.load("whole.h5"))


def interrupted_after(monkeypatch, done):
    partial = in_python()  # before sweep is replaced: fl.sweep is looked up when it is first used
    for values in partial.data_vars.values():
        values[done:] = np.nan
    partial.attrs["runs_done"] = done * 4

    def sweep(*_, **__):
        raise fl.SweepInterrupted(partial)

    monkeypatch.setattr(fl, "sweep", sweep)


def test_interrupted_without_out_says_that_nothing_is_kept(frictionloop, monkeypatch):
    interrupted_after(monkeypatch, 1)
    answer = frictionloop(*GRID)
    assert answer.code == 130
    assert answer.err == "interrupted: 4 of 12 runs done, not kept (--out FILE keeps it)\n"
    assert "4 of 12" in answer.out


def test_interrupted_json_says_that_it_is_not_complete(frictionloop, monkeypatch):
    interrupted_after(monkeypatch, 2)
    answer = frictionloop(*GRID, "--json", "--out", "kept.h5")
    assert answer.code == 130
    found = answer._replace(code=0, err="").json()
    assert (found["runs_done"], found["complete"]) == (8, False)
    assert found["metrics"]["rms_error"][2] == [[None, None], [None, None]]
    assert answer.err.endswith(f"/elsewhere/frictionloop {shlex.join(GRID)} --json --out kept.h5 --resume\n")


def test_resume_of_another_sweep_is_refused(frictionloop):
    assert frictionloop(*GRID, "--out", "kept.h5").code == 0
    before = Path("kept.h5").read_bytes()
    answer = frictionloop(*GRID, "--controller.delay_s", "1e-4", "--out", "kept.h5", "--resume")
    assert answer.code == 2
    assert answer.err.startswith("error: kept.h5: holds another sweep")
    assert Path("kept.h5").read_bytes() == before
    assert frictionloop(*GRID, "--out", "kept.h5").code == 0  # a finished one may be replaced


POPULATION = ("sweep", "--preset", "bench", "--duration-s", "0.2", "--fingers", "4", "--fingers-seed", "5")


def test_fingers_in_json_are_those_of_python(frictionloop):
    answer = frictionloop(*POPULATION, "--coefficients", "0.4,1.2", "--loads", "0.5", "--json").json()
    found = fl.people(fl.bench(), 4, 5, None, (0.5, 0.5), (0.4, 1.2), 0.2).to_dict()
    for name in ("served", "share", "asked_n", "population", "each", "metrics", "replaced"):
        assert answer[name] == found[name]
    assert [each["code"] for each in answer["findings"]] == [each["code"] for each in found["findings"]]


def test_files_of_fingers_hold_who_can_what(frictionloop):
    assert frictionloop(*POPULATION, "--csv", "f.csv", "--out", "f.h5").code == 0
    kept = fl.load("f.h5")
    with open("f.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["served"] for row in rows] == [str(each) for each in kept.served.values]
    assert [float(row["coefficient"]) for row in rows] == kept.coefficient.values.tolist()
    before = Path("f.csv").read_bytes()
    resumed = frictionloop(*POPULATION, "--csv", "f.csv", "--out", "f.h5", "--resume")
    assert (resumed.code, Path("f.csv").read_bytes()) == (0, before)


def test_fingers_that_were_interrupted_go_on(frictionloop, monkeypatch):
    partial = fl.people(fl.bench(), 4, 5, duration_s=0.2)

    def stopped(*_, **__):
        raise fl.PeopleInterrupted(partial)

    monkeypatch.setattr(fl, "people", stopped)
    answer = frictionloop(*POPULATION, "--out", "f.h5")
    assert answer.code == 130
    assert answer.err.startswith("interrupted: 4 of 4 runs done, kept in f.h5\ncontinue with: ")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--over", "controller.kp=1,2", "--population", "p.toml"), "population: accepted with --fingers N"),
        (("--fingers", "3", "--friction.nominal_n", "2"), "friction.nominal_n: each finger brings its own"),
        (("--fingers", "3", "--over", "controller.kp=1,2"), "over: give --over"),
        (("--fingers", "3", "--coefficients", "2,1"), "coefficients = '2,1': must be"),
        ((), "over: give --over"),
    ],
    ids=str,
)
def test_what_is_wrong_is_one_line(frictionloop, words, said):
    answer = frictionloop("sweep", "--preset", "bench", *words)
    assert (answer.code, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert answer.err.startswith(f"error: {said}")
