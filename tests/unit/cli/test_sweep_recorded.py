"""A recorded disturbance in sweeps: how much of it each finger's loop leaves, and what has no value is left out."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.operating_point import at_levels
from frictionloop.loop.sweep_figure import figure_of

N = 6
TIME_S = np.arange(1000) / 1000.0
FORCE_N = 0.3 + 0.04 * np.sin(2 * np.pi * 3 * TIME_S)
BENCH = ("--preset", "bench", "--controller.kp", 2.0, "--controller.ki", 20.0, "--duration-s", 1)
CONSTANT = ("--setpoint.kind", "constant", "--setpoint.offset_n", 0.5)


@pytest.fixture
def recorded(tmp_path):
    path = tmp_path / "f.csv"
    np.savetxt(path, np.c_[TIME_S, FORCE_N], delimiter=",", header="time_s,force_n", comments="")
    told = {"kind": "recording", "path": path, "column": "force_n", "remove_mean": "true"}
    return [word for name, value in told.items() for word in (f"--disturbance.{name}", value)]


def test_fingers_tell_what_is_left_of_a_recording(frictionloop, recorded):
    words = ("sweep", *BENCH, *CONSTANT, *recorded, "--fingers", N)
    found = frictionloop(*words, "--json").json()
    system = fl.bench().evolve({"controller.kp": 2.0, "controller.ki": 20.0, "setpoint": fl.Constant(offset_n=0.5)})
    slide = fl.Recording(path=recorded[3], column="force_n", remove_mean=True)
    system = system.evolve({"disturbance": slide})
    one_by_one = [
        fl.metrics(fl.simulate(system.evolve(dict(each)), 1.0))["disturbance_left"] for each in fl.fingers(N, 0)
    ]
    assert np.ravel(found["metrics"]["disturbance_left"]).tolist() == one_by_one
    of_all = found["population"]["disturbance_left"]
    assert of_all == {"median": np.median(one_by_one), "worst_decile": max(one_by_one), "fingers": N}


def test_what_has_no_value_is_told_and_of_the_recording_its_level(frictionloop, recorded):
    found = frictionloop("sweep", *BENCH, *CONSTANT, *recorded, "--fingers", N, "--json").json()
    told = {each["code"]: each for each in found["findings"]}
    assert told["METRIC-NONE"]["value"] == ["r2_identity"]
    assert told["RECORDED-LEVEL"]["where"] == {"recording": "disturbance"}


def test_points_take_it_and_the_smallest_is_the_best(frictionloop, recorded):
    words = ("sweep", "--preset", "feasible", *CONSTANT, *recorded, "--disturbance.offset_n", 0, "--duration-s", 1)
    words += ("--metrics", "disturbance_left")
    found = frictionloop(*words, "--over", "controller.kp=1,5,10", "--json").json()
    left = np.ravel(found["metrics"]["disturbance_left"])
    assert found["best"]["disturbance_left"]["value"] == left.min() and np.all(np.diff(left) < 0)


def test_panels_without_a_value_are_left_out():
    system = fl.bench().evolve({"setpoint": fl.Constant(offset_n=0.5)})
    grid = fl.sweep(system, fl.fingers(3, 0), 0.2, metrics=["r2_identity", "rms_error"])
    figure = figure_of(grid)
    assert [panel.get_ylabel() for panel in figure.axes] == ["rms_error (mN)"]
    assert "No value: r2_identity." in figure.get_supxlabel()
    nothing = grid.copy(deep=True)
    nothing["rms_error"][:] = np.nan
    assert len(figure_of(nothing).axes) == 2


# What a design takes of recorded signals.


@pytest.mark.slow
def test_a_design_takes_the_levels_of_a_recorded_set_point(frictionloop, tmp_path):
    (tmp_path / "wanted.csv").write_text("# rate_hz: 100\nforce [N]\n0.4\n0.8\n0.5\n")
    (tmp_path / "slide.csv").write_text("# rate_hz: 100\nforce [N]\n0.4\n0.8\n0.5\n")
    recorded = ("--setpoint.kind", "recording", "--setpoint.path", "wanted.csv", "--setpoint.column", "force")
    slide = ("--disturbance.kind", "recording", "--disturbance.path", "slide.csv", "--disturbance.column", "force")
    answer = frictionloop("design", "controller", *recorded, *slide, "--law", "pi", "--out", "new.toml", "--json")
    told = answer.json()
    assert told["tracking"] is None  # a recording is shorter than 1 s
    levels = {each["where"]["recording"]: each for each in told["findings"] if each["code"] == "RECORDED-LEVEL"}
    assert (levels["setpoint"]["value"], levels["setpoint"]["amplitude"]) == pytest.approx((0.6, 0.2))
    new = fl.read_toml(tmp_path / "new.toml")
    assert (new.setpoint.kind, new.disturbance.kind) == ("recording", "recording")
    levels = at_levels(new)
    assert (levels.setpoint.offset_n, levels.setpoint.amplitude_n) == pytest.approx((0.6, 0.2))
    assert levels.disturbance == fl.Constant(offset_n=0.0)  # the mean friction was left in
    less = new.evolve({"disturbance.scale": 0.1})
    assert at_levels(less).disturbance.offset_n == pytest.approx(0.17 / 3)
