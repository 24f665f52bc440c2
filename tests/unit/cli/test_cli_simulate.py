"""``frictionloop simulate``: the same run as in Python, said on a screen, as JSON and in files."""

from __future__ import annotations

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


def test_json_holds_the_metrics_of_the_same_run_in_python(frictionloop):
    answer = frictionloop(*SHORT, "--controller.kp", "12", "--seed", "3", "--json").json()
    system = fl.feasible().evolve({"controller.kp": 12})
    run = fl.simulate(system, 0.2, seed=3)
    line = fl.regression(run)
    calm = fl.simulate(system.evolve({"disturbance": fl.Constant(offset_n=float(run.d.mean()))}), 0.2, seed=3)
    assert answer["metrics"] == {
        "r2_identity": fl.r2_identity(run),
        "r2_bound": fl.r2_bound(run),
        "r2_regression": line.r2,
        "slope": line.slope,
        "intercept": line.intercept_n,
        "rms_error": fl.rms_error(run),
        "disturbance_left": pytest.approx(
            np.sqrt(np.mean((run.f_a.values - calm.f_a.values) ** 2)) / np.std(run.d.values), rel=1e-12
        ),
        "rms_error_turns": fl.rms_error(run),  # nobody turns
        "turn_peak": None,
        "feedback_share": None,
        "output_noise": fl.output_noise(run),
        "saturation_index": fl.saturation_index(run),
        "perceptual_index": None,  # what is felt of a finger that is not one says little
        "relative_index": None,
    }
    assert (answer["scored"], answer["steps"]) == (1, [])
    assert fl.System.from_tree(answer["system"]) == system
    assert (answer["seed"], answer["duration_s"], answer["score_from_s"]) == (3, 0.2, 0)
    assert answer["saved"] == {"run": None, "plot": None, "system": None}
    assert answer["elapsed_s"] > 0


def test_score_from_s_leaves_the_start_out(frictionloop):
    answer = frictionloop(*SHORT, "--score-from-s", "0.1", "--json").json()
    run = fl.simulate(fl.feasible(), 0.2)
    assert answer["metrics"]["rms_error"] == fl.rms_error(run, run.time >= 0.1)


def test_json_has_no_nan_for_a_constant_set_point(frictionloop):
    answer = frictionloop(*SHORT, "--setpoint.kind", "constant", "--setpoint.offset_n", "0.5", "--json").json()
    assert answer["metrics"]["r2_identity"] is None
    assert answer["metrics"]["rms_error"] > 0


def test_summary_says_system_metrics_and_time(frictionloop):
    answer = frictionloop(*SHORT, "--controller.ki=3")
    assert (answer.code, answer.err) == (0, "")
    for words in ("feasible() with controller.ki = 3", "pi: kp=10, ki=3", "r2_bound", " mN ", "simulated in"):
        assert words in answer.out
    assert max(map(len, answer.out.splitlines())) <= 80


def test_summary_of_a_constant_set_point_has_no_rows_without_a_value(frictionloop):
    answer = frictionloop(*SHORT, "--setpoint.kind", "constant")
    assert answer.code == 0
    assert "nan" not in re.findall(r"\w+", answer.out)
    assert not re.search(r"^\w+ +-( |$)", answer.out, re.MULTILINE)
    assert "r2_" not in answer.out and "rms_error" in answer.out


def test_order_of_flags_does_not_matter_for_a_kind(frictionloop):
    flags = ("--setpoint.frequency_hz", "5", "--setpoint.kind", "sine", "--setpoint.offset_n", "0.6", "--json")
    told = frictionloop(*SHORT, *flags)
    assert json.loads(told.out)["system"]["setpoint"] == {
        "kind": "sine",
        "offset_n": 0.6,
        "amplitude_n": 0,
        "frequency_hz": 5,
    }
    left = "setpoint.kind = sine: amplitude_n = 0.0 by default; the log_sweep of feasible() had 0.18"
    assert left in told.err


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
    assert answer.out.endswith("saved run as run.h5\nsaved plot as run.svg\nsaved system as bench.toml\n")
    assert fl.load("run.h5").identical(fl.simulate(fl.feasible(), 0.2))
    assert Path("run.svg").read_text().startswith("<?xml")
    assert fl.read_toml("bench.toml") == fl.feasible()
    again = frictionloop("simulate", "bench.toml", "--duration-s", "0.2", "--out", "again.h5")
    assert again.out.startswith("system       bench.toml")
    assert fl.load("again.h5").identical(fl.load("run.h5"))


def test_a_saved_run_counts_what_its_command_counted(frictionloop):
    answer = frictionloop(*SHORT, "--score-from-s", "0.1", "--out", "late.h5", "--json").json()
    assert fl.load("late.h5").scored.attrs == fl.simulate(fl.bench(), 0.2).scored.attrs
    assert fl.metrics(fl.load("late.h5"))["rms_error"] == answer["metrics"]["rms_error"]
    assert fl.metrics(fl.simulate(fl.feasible(), 0.2))["rms_error"] != answer["metrics"]["rms_error"]


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


def test_a_recording_says_what_was_found_in_the_file(frictionloop, tmp_path):
    rows = "".join(f"{k / 1000:.3f},{700 + 50 * (k % 2)}\n" for k in range(1001))
    (tmp_path / "slide.csv").write_text("Time (s),Ft [mN]\n" + rows)
    flags = ("--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "slide.csv"))
    still = ("--setpoint.kind", "constant", "--setpoint.offset_n", "0.5", "--disturbance.column", "Ft")
    said = " ".join(frictionloop("simulate", *flags, *still, "--duration-s", "0.9").out.split())
    assert "in mN by the file, 1001 samples at 1000 Hz" in said
    assert "The set-point is out of reach 100% of the time" in said
    assert "--disturbance.remove_mean true" in said


def test_json_says_what_was_read_and_what_is_told(frictionloop, tmp_path):
    rows = "".join(f"{k / 1000:.3f},{700 + 50 * (k % 2)}\n" for k in range(1001))
    (tmp_path / "slide.csv").write_text("Time (s),Ft\n" + rows)
    flags = ("--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "slide.csv"))
    flags = (*flags, "--disturbance.column", "Ft", "--disturbance.remove_mean", "true", "--duration-s", "0.5", "--json")
    read = json.loads(frictionloop("simulate", *flags).out)["recording"]
    told = {"column": "Ft", "head": "names in line 1", "unit": "N", "unit_by": "taken for N", "newtons_per_unit": 1}
    told |= {"rate_hz": 1000, "rate_by": "'Time (s)'", "samples": 1001, "largest_n": 750}
    assert told.items() <= read["disturbance"].items()
    assert [read["disturbance"][name] for name in ("lowest_n", "highest_n", "rms_n")] == pytest.approx(
        [-25 + 25 / 1001, 25 + 25 / 1001, 25], rel=1e-5
    )
    assert "meant? --disturbance.unit mN" in read["notes"]
    assert "The run takes the first 0.5 s of the 1.001 s of the recorded disturbance." in read["notes"]
    assert "recording" not in frictionloop(*SHORT, "--json").json()


def test_a_recording_in_another_unit_is_asked_about(frictionloop, tmp_path):
    rows = "".join(f"{0.001 * k:.3f}".replace(".", ",") + f";{700 + 50 * (k % 2)},5\n" for k in range(300))
    (tmp_path / "slide.csv").write_text("Zeit;Kraft\n" + rows)
    flags = ("--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "slide.csv"))
    flags = (*flags, "--disturbance.column", "Kraft", "--disturbance.decimal", ",", "--duration-s", "0.2")
    said = " ".join(frictionloop("simulate", *flags).out.split())
    assert "disturbance = 750 N, usual are 0 to 10; meant? --disturbance.unit mN" in said
    assert "did you mean a" not in said
    removed = ("--disturbance.remove_mean", "true")
    said = " ".join(frictionloop("simulate", *flags, *removed).out.split())
    assert "disturbance = 750 N, usual are 0 to 10; meant? --disturbance.unit mN" in said
    assert "out of reach" not in said
    given = frictionloop("simulate", *flags, *removed, "--disturbance.unit", "mN").out
    assert "--disturbance.unit" not in given


@pytest.mark.parametrize(
    ("header", "given", "meant"),
    [("F", ("unit", "mN"), "unit N"), ("F [mN]", (), "scale 1"), ("F", (), "unit")],
)
def test_a_disturbance_that_hardly_varies_is_asked_about(frictionloop, tmp_path, header, given, meant):
    numbers = 0.2 if meant != "unit" else 0.0002  # +- half of it
    rows = "".join(f"{k / 1000},{numbers * (k % 2)}\n" for k in range(300))
    (tmp_path / "slide.csv").write_text(f"time_s,{header}\n" + rows)
    flags = ("--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "slide.csv"))
    flags = (*flags, "--disturbance.column", "1", "--disturbance.remove_mean", "true", "--duration-s", "0.2")
    more = (f"--disturbance.{given[0]}", given[1]) if given else ()
    said = " ".join(frictionloop("simulate", *flags, *more).out.split())
    assert f"disturbance rms = 0.0001 N, usual are 0.001 to 10; meant? --disturbance.{meant}" in said


def test_a_set_point_above_the_finger_is_told(frictionloop):
    high = ("--setpoint.kind", "constant", "--setpoint.offset_n", "1.7", "--disturbance.kind", "constant")
    said = frictionloop("simulate", *high, "--disturbance.offset_n", "0", "--duration-s", "0.1").out
    assert "The set-point is out of reach 100% of the time: 0.0744 to 0.8 N could be had, as medians" in said
    assert "did you mean a lower set-point?" in said
    assert "out of reach" not in frictionloop("simulate", "--preset", "feasible", "--duration-s", "0.1").out


def test_a_saved_system_is_short_and_all_of_it_on_request(frictionloop):
    short = ("simulate", "--preset", "bench", "--duration-s", "0.01", "--save-system")
    assert frictionloop(*short, "short.toml").code == frictionloop(*short, "whole.toml", "--all").code == 0
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
    assert "in mN by the file" in frictionloop("simulate", *flags).out


@pytest.mark.slow
def test_a_mean_left_in_is_told_with_ringing_and_what_could_be_had(frictionloop, with_a_mean):
    flags = ("--preset", "bench", *with_a_mean, "--disturbance.column", "Ft", "--duration-s", "0.5")
    said = " ".join(frictionloop("simulate", *flags).out.split())
    assert "This loop rings near" in said
    assert "N could be had, as medians of what is scored. So" in said
    assert "of the commands are clamped." in said
    assert "--disturbance.remove_mean true" in said
    calm = frictionloop("simulate", *flags, "--disturbance.remove_mean", "true", "--controller.kind", "lookup").out
    assert "remove_mean true?" not in calm


def test_a_path_without_a_kind_names_the_flag(frictionloop):
    said = frictionloop("simulate", "--preset", "feasible", "--disturbance.path", "slide.csv").err
    assert "give that too, as --disturbance.kind recording" in said


def test_a_recording_too_short_names_the_flag_and_the_longest(frictionloop, with_a_mean):
    flags = ("simulate", "--preset", "feasible", *with_a_mean, "--disturbance.column", "Ft", "--duration-s")
    assert frictionloop(*flags, "0.5").code == 0  # 500 samples at 1 kHz, the last held for a millisecond
    assert "duration_s (--duration-s) must be at most 0.5 s" in frictionloop(*flags, "0.6").err


@pytest.fixture
def sliding(tmp_path):
    """Return the flags of a recording of 2 s whose mean over the first second is not that of all of it."""
    rows = "".join(f"{k / 1000:.3f},{0.5 + 0.02 * (k >= 1000) + 0.01 * (k % 20 < 10):.3f}\n" for k in range(2000))
    (tmp_path / "slide.csv").write_text("time_s,force_n\n" + rows)
    return ("--disturbance.kind", "recording", "--disturbance.path", str(tmp_path / "slide.csv"))


@pytest.mark.slow
def test_what_a_recording_leaves_out_and_what_comes_on_top_is_told(frictionloop, sliding):
    whole = (*sliding, "--disturbance.column", "force_n", "--disturbance.remove_mean", "true")
    said = " ".join(frictionloop("simulate", "--preset", "bench", *whole, "--duration-s", "1").out.split())
    assert "takes the first 1 s of the 2 s of the recorded disturbance" in said
    assert "--disturbance.stop_s 1 removes that of the part that runs" in said
    flags = re.search(r"It is alone with ((?:--\S+ \S+ ?)+)", said)[1].split()
    flags += ["--disturbance.stop_s", "1", "--duration-s", "1"]
    alone = frictionloop("simulate", "--preset", "bench", *whole, *flags)
    assert "takes the first" not in alone.out
    assert "comes on top" not in alone.out
    paper = frictionloop("simulate", "--preset", "feasible", *whole, "--duration-s", "2").out
    assert "takes the first" not in paper
    assert "comes on top" not in paper


def test_a_finger_that_is_held_still_varies_by_the_recording_alone(sliding):
    from frictionloop.parameters.still import STILL

    slide = fl.Recording(path=sliding[-1], column="force_n", remove_mean=True)
    system = fl.bench().evolve({"controller.kind": "lookup", "setpoint": fl.Constant(offset_n=0.6), **STILL})
    run = fl.simulate(system.evolve({"disturbance": slide}), 2.0)
    late = run.scored.values & (run.time.values > 0.5)
    varies = (run.f_a - run.d).values[late]
    assert np.std(varies) < 0.1 * np.std(run.d.values[late])


def test_a_column_of_times_that_nobody_asked_for_is_said_to_be_the_default(frictionloop, sliding):
    said = frictionloop("simulate", "--preset", "feasible", *sliding, "--duration-s", "1").err
    assert "--disturbance.column and --setpoint.column) holds times; accepted: 'force_n'" in said


@pytest.mark.slow
def test_gains_are_advised_and_designed_at_the_same_levels(sliding):
    from frictionloop.analysis.levels import at_levels
    from frictionloop.cli import advice
    from frictionloop.cli.ringing import of_system
    from frictionloop.design.corners import band_of

    slide = fl.Recording(path=sliding[-1], column="force_n", remove_mean=True)
    system = fl.bench().evolve({"disturbance": slide})
    run = fl.simulate(system, 1.0)
    mask = run.scored.values
    found = advice.ringing(run, mask, {"r2_bound": 1.0, "r2_identity": -1.0, "saturation_index": 0.9})
    levels = at_levels(system, run, mask)  # a part of the recording is scored, which has a mean of its own
    forces = [point.elements.force_n for point in band_of(levels)]
    assert (found.band.low_n, found.band.high_n) == pytest.approx((min(forces), max(forces)))
    assert of_system(levels).band[:2] == found.band[:2]


def test_reading_a_recording_is_a_phase_of_its_own_and_done_once(frictionloop, sliding, monkeypatch):
    from frictionloop.cli import screen
    from frictionloop.recordings import read

    phases, reads, waiting, reader = [], [], screen.waiting, read._READERS[".csv"]
    monkeypatch.setattr(screen, "waiting", lambda text: phases.append(text) or waiting(text))
    counted = {**read._READERS, ".csv": lambda recording: reads.append(recording) or reader(recording)}
    monkeypatch.setattr(read, "_READERS", counted)
    frictionloop("simulate", "--preset", "feasible", *sliding, "--disturbance.column", "1", "--duration-s", "0.1")
    assert phases[0] == "reading the recording" and phases[1].startswith("loading the compiled loop")
    assert len(reads) == 1
    phases.clear()
    frictionloop(*SHORT)
    assert "reading the recording" not in phases


def test_a_file_that_is_replaced_is_said(frictionloop, tmp_path):
    flags = ("simulate", "--duration-s", "0.1", "--plot", str(tmp_path / "run.svg"))
    assert "which replaced" not in frictionloop(*flags).out
    assert "run.svg, which replaced the one that was there" in " ".join(frictionloop(*flags).out.split())


def test_a_bound_below_zero_is_explained_without_a_difference(frictionloop):
    below = ("--setpoint.kind", "sine", "--setpoint.offset_n", "-0.5", "--setpoint.amplitude_n", "0.1")
    said = " ".join(frictionloop("simulate", *below, "--duration-s", "1").out.split())
    row = said.partition("r2_bound")[2].partition("r2_regression")[0]
    assert row.endswith("below 0: reach alone misses f_r by more than f_r varies ")


def test_the_error_in_open_loop_stands_beside_that_of_the_loop(frictionloop):
    given = ("simulate", "--preset", "bench", "--controller.kp", "0.03", "--controller.ki", "20", "--duration-s", "3")
    told = frictionloop(*given, "--json").json()
    expected_n = fl.rms_error(fl.simulate(fl.bench().evolve({"controller.kind": "lookup"}), 3.0))
    assert told["open_loop"]["rms_error"] == pytest.approx(expected_n, rel=1e-12)
    assert f"{1e3 * expected_n:.4g} mN in open loop" in " ".join(frictionloop(*given).out.split())
    alone = frictionloop("simulate", "--preset", "bench", "--controller.kind", "lookup", "--duration-s", "1")
    assert "in open loop" not in alone.out
