"""``frictionloop sweep``: the same numbers as in Python, best points, and nothing lost on Ctrl-C."""

from __future__ import annotations

import csv
import math
import re
import shlex
import signal
import time
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.cli.outcome import Outcome
from frictionloop.cli.ringing import points_of
from frictionloop.cli.sweep import axes_of

BENCH = ("sweep", "--preset", "bench", "--duration-s", "0.5", "--metrics", "rms_error")
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


def test_summary_names_the_best_points(frictionloop):
    answer = frictionloop(*GRID)
    assert (answer.code, answer.err) == (0, "")
    for words in ("rms_error", " mN", "controller.kp=", "3 x 2 points x 2 seeds of 0.1 s, 12 of 12 runs done"):
        assert words in answer.out
    *lines, command = answer.out.splitlines()  # which is to be copied, and is not broken
    assert max(map(len, lines)) <= 80 and command.startswith("  frictionloop design check ")


def test_words_can_be_swept(frictionloop):
    answer = frictionloop(*SHORT, "--over", "setpoint.kind=log_sweep,constant", "--json").json()
    assert answer["best"]["r2_identity"]["point"] == {"setpoint.kind": "log_sweep"}
    assert answer["metrics"]["r2_identity"][1] == [None]


def test_sweep_without_any_value_is_still_complete(frictionloop):
    constant = ("--setpoint.kind", "constant", "--setpoint.offset_n", "0.5")
    tokens = (*SHORT, "--over", "controller.kp=1,2", *constant, "--metrics", "r2_identity")
    assert frictionloop(*tokens, "--json").json()["complete"]
    assert "no run has a value" in frictionloop(*tokens).out


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


@pytest.mark.parametrize(
    ("metric", "at"),
    [
        ("rms_error", 0),
        ("saturation_index", 0),
        ("perceptual_index", 0),
        ("r2_identity", 3),
        ("slope", 1),
        ("r2_bound", 3),
    ],
)
def test_best_is_the_smallest_the_largest_or_the_nearest_to_one(metric, at):
    result = fl.sweep(fl.feasible(), {"controller.kp": [1, 2, 3, 4]}, 0.01, metrics=[metric])
    result[metric][:] = np.array([[0.5], [1.2], [0.7], [1.4]])
    best = Outcome(result, 1.0, complete=True).best(metric)
    assert best.point == {"controller.kp": at + 1}
    assert best.at_end == (("controller.kp",) if at != 1 else ())
    assert best.others == 0


def test_equal_points_are_counted():
    result = fl.sweep(fl.feasible(), {"controller.kp": [1, 2, 3, 4]}, 0.01)
    result["saturation_index"][:] = np.array([[0.5], [0.0], [0.0], [np.nan]])
    best = Outcome(result, 1.0, complete=False).best("saturation_index")
    assert (best.point, best.others, best.at_end) == ({"controller.kp": 2}, 1, ())


def interrupt_once_running(running, kept):
    while not kept.exists():
        assert running.poll() is None, running.communicate()
        time.sleep(0.01)
    time.sleep(0.3)
    running.send_signal(signal.SIGINT)
    return *running.communicate(timeout=60), running.returncode


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done_and_resume_finishes_it(frictionloop, process, tmp_path):
    long = ("--setpoint.sweep_s", "100", "--over", "controller.kp=1:18:64", "--over", "controller.ki=1:10:10:log")
    tokens = ("sweep", "--preset", "feasible", *long, "--duration-s", "100", "--out")
    running = process(*tokens, "kept.h5", "--jobs", "1")
    out, err, code = interrupt_once_running(running, tmp_path / "kept.h5")
    assert code == 130
    *_, said, command = err.splitlines()  # after lines of progress
    done = int(said.split()[1])
    assert 0 < done < 640
    assert said == f"interrupted: {done} of 640 runs done, kept in kept.h5"
    assert f"{done} of 640 runs done" in out
    assert int(np.isfinite(fl.load("kept.h5").rms_error).sum()) == done

    assert command.startswith("continue with: python -m frictionloop sweep ")
    assert "keeps an unfinished sweep; add --resume" in frictionloop(*tokens, "kept.h5").err
    again = shlex.split(command.removeprefix("continue with: python -m frictionloop "))
    assert again == [*tokens, "kept.h5", "--jobs", "1", "--resume"]
    resumed = frictionloop(*again[:-3], "--resume")
    assert (resumed.code, resumed.noted) == (0, [])
    assert "640 of 640 runs done" in resumed.out
    assert frictionloop(*tokens, "whole.h5").code == 0
    assert fl.load("kept.h5").identical(fl.load("whole.h5"))


def interrupted_after(monkeypatch, done):
    partial = in_python()  # before sweep is replaced: fl.sweep is looked up when it is first used
    for values in partial.data_vars.values():
        values[done:] = np.nan

    def sweep(*_, **__):
        raise fl.SweepInterrupted(partial)

    monkeypatch.setattr("frictionloop.loop.sweep.sweep", sweep)
    monkeypatch.setattr("frictionloop.cli.outcome.compiled", lambda *_: None)


def test_interrupted_without_out_says_that_nothing_is_kept(frictionloop, monkeypatch):
    interrupted_after(monkeypatch, 1)
    answer = frictionloop(*GRID)
    assert answer.code == 130
    assert answer.err == "interrupted: 4 of 12 runs done, not kept: without --out there is nothing to continue from\n"
    assert "4 of 12 runs done" in answer.out


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


def test_fingers_of_a_measured_population(tmp_path, capsys):
    from frictionloop.cli.population import population_of

    file = tmp_path / "people.toml"
    file.write_text('fingers = 4\n[[value]]\npath = "friction.nominal_n"\nmedian = 1.2\nspread = 0.0\n')
    assert {each["friction.nominal_n"] for each in population_of(fl.bench(), 5, 0, None, file)} == {1.2}
    with pytest.raises(SystemExit) as left:
        main(["sweep", "--over", "controller.kp=1,2", "--population", str(file)])
    assert left.value.code == 2 and "with --fingers N" in capsys.readouterr().err


def test_few_points_are_listed_and_those_that_ring_are_marked(frictionloop):
    # The ultimate gain tells which proportional gains are stable, whatever the metrics of so short a run.
    bench = fl.bench().evolve({"controller.kind": "pi", "controller.ki": 1.0})
    ultimate = fl.kp_limit(bench)
    values = [f"{share * ultimate:.4g}" for share in (0.1, 3.0)]
    tokens = ("sweep", "--preset", "bench", "--duration-s", "0.1", "--controller.kind", "pi", "--controller.ki", "1")
    answer = frictionloop(*tokens, "--over", f"controller.kp={','.join(values)}")
    first, second = (next(line for line in answer.out.splitlines() if line.startswith(each)) for each in values)
    assert "RINGS" not in first and second.rstrip().endswith("RINGS")
    assert "lie beyond" not in answer.out


def test_few_points_of_two_axes_are_listed_too(frictionloop):
    over = ("--over", "motion.speed_mm_s=60,200", "--over", "finger.slip_length_um=11.5,0")
    lines = frictionloop("sweep", "--preset", "bench", "--duration-s", "0.1", *over).out.splitlines()
    assert any(line.startswith("motion.speed_mm_s,") for line in lines)
    for point in ("60, 11.5", "60, 0", "200, 11.5", "200, 0"):
        assert sum(line.startswith(point) for line in lines) == 1


def test_where_gains_vary_the_loop_of_the_best_point_is_told_apart_from_its_error(frictionloop):
    """A loop that rings may have the least error of some runs."""
    swept = ("sweep", "--preset", "feasible", "--disturbance.kind", "constant", "--duration-s", "0.1")
    for kp in ("4,5", "200,201"):
        out = frictionloop(*swept, "--over", f"controller.kp={kp}", "--metrics", "rms_error").out
        (best,) = re.findall(r"^rms_error .* controller\.kp=(\d+)$", out, re.M)
        peak = max(loop.sensitivity_peak() for loop in points_of(fl.feasible().evolve({"controller.kp": float(best)})))
        how = "RINGS" if peak == math.inf else "does not ring as described"
        assert f"\nThe loop with the best rms_error {how}.\n" in out
        command = f"  frictionloop design check --preset feasible --controller.kp {best}\n"
        assert out.endswith(command)
        verdict = frictionloop(*command.split()[1:]).out.split()[0]
        assert (verdict == "HOLDS") == (kp == "4,5")
    assert "design check" not in frictionloop(*swept, "--over", "plate.cutoff_hz=90,100").out


def test_a_loop_that_no_linear_analysis_looks_at_is_not_said_to_be_calm(frictionloop):
    Path("d.csv").write_text("d\n" + "0.1\n0.12\n" * 300)
    recorded = ("--disturbance.kind", "recording", "--disturbance.path", "d.csv", "--disturbance.rate_hz", "500")
    still = ("--friction.occlusion_ratio", "1", "--friction.moist_loss", "0", "--finger.slip_length_um", "0")
    out = frictionloop(*BENCH, *recorded, *still, "--over", "controller.kp=9,10", "--controller.ki", "0").out
    assert "does not ring" not in out
    check = "  frictionloop design check --preset bench --finger.slip_length_um 0 --controller.ki 0 --controller.kp"
    said = f"Its margins, at other slip lengths and speeds too, without this disturbance:\n{check}"
    assert out.rpartition(" ")[0].endswith(said)


def test_the_check_of_a_best_point_is_of_that_point(frictionloop):
    out = frictionloop(*BENCH, "--controller.kp", "0.01", "--over", "controller.kp=0.0123456789,0.0123456789012").out
    (best,) = re.findall(r"--preset bench --controller\.kp (\S+)$", out, re.M)
    assert best in ("0.0123456789", "0.0123456789012")
