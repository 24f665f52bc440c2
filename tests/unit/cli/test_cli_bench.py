"""``frictionloop simulate --preset bench``: the device, its finger, and what is said of a loop that rings."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli.flags import PresetName
from frictionloop.parameters import PRESETS
from frictionloop.report.run_figure import figure_of

SHORT = ("simulate", "--preset", "bench", "--duration-s", "1")
HELD = tuple(word for path, gain in fl.RETUNED.items() for word in (f"--{path}", str(gain)))


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")


def test_presets_are_those_of_the_package():
    assert get_args(PresetName) == tuple(PRESETS)


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_runs(frictionloop, name):
    answer = frictionloop("simulate", "--preset", name, "--duration-s", "0.2", "--json").json()
    assert fl.System.from_tree(answer["system"]) == PRESETS[name]()


def test_score_from_s_does_not_bring_reversals_back(frictionloop):
    # At t = 0 the finger rests at the end of its stroke.
    answer = frictionloop(*SHORT, *HELD, "--score-from-s", "0.5", "--seed", "2", "--json").json()
    run = fl.simulate(fl.bench().evolve(fl.RETUNED), 1.0, seed=2)
    mask = (run.time.values >= 0.5) & run.scored.values
    assert answer["scored"] == mask.mean() <= 0.5
    assert answer["rms_error_n"] == fl.rms_error(run, mask)
    assert answer["relative_index"] == fl.relative_index(run, mask)


FLAGS = {
    "finger.stiffness_n_m": 800.0,
    "motion.speed_mm_s": 40.0,
    "touch.position.noise_um": 20.0,
    "touch.load.noise_n": 0.002,
    "plate.q": 115.0,
    "sensor.resonance_hz": 200.0,
    "controller.jitter_s": 1e-5,
    "controller.lost_ticks": 0.01,
    "controller.model.nominal_n": 0.9,
    "friction.load_exponent": 1.0,
}


def test_every_block_has_flags(frictionloop):
    words = [word for path, value in FLAGS.items() for word in (f"--{path.replace('_', '-')}", str(value))]
    answer = frictionloop(*SHORT, *words, "--json").json()
    assert fl.System.from_tree(answer["system"]) == fl.bench().evolve(FLAGS)


@pytest.mark.parametrize("turn", [1, -1])
def test_order_of_flags_does_not_matter_for_kinds(frictionloop, turn):
    kinds = [("--motion.kind", "strokes"), ("--finger.kind", "skin"), ("--friction.kind", "finger")]
    values = [("--finger.mass_kg", "2e-4"), ("--motion.load_n", "0.4"), ("--friction.nominal_n", "0.9")]
    pairs = [*kinds, *values][::turn]
    words = [word for pair in pairs for word in pair]
    system = fl.System.from_tree(frictionloop("simulate", "--duration-s", "0.2", *words, "--json").json()["system"])
    assert (system.finger.mass_kg, system.motion.load_n, system.friction.nominal_n) == (2e-4, 0.4, 0.9)


def test_a_rigid_finger_on_the_bench(frictionloop):
    answer = frictionloop(*SHORT, "--finger.kind", "rigid", "--json").json()
    assert answer["system"]["finger"] == {"kind": "rigid"}


@pytest.mark.slow
def test_a_bench_can_be_saved_and_read_again(frictionloop):
    words = ("--finger.slip_length_um", "30", "--touch.load.touch_n", "0.03", "--plate.q", "100")
    first = frictionloop(*SHORT, *words, "--save-system", "mine.toml", "--out", "a.h5")
    assert (first.code, first.err) == (0, "")
    again = frictionloop("simulate", "mine.toml", "--duration-s", "1", "--out", "b.h5")
    assert (again.code, again.err) == (0, "")
    assert fl.load("a.h5").identical(fl.load("b.h5"))
    assert fl.read_toml("mine.toml").touch.load.touch_n == 0.03


def test_a_file_may_begin_with_the_bench(frictionloop):
    Path("mine.toml").write_text('preset = "bench"\n[finger]\nkind = "rigid"\n[plate]\nq = 460.0\n')
    answer = frictionloop("simulate", "mine.toml", "--duration-s", "0.2", "--json").json()
    assert fl.System.from_tree(answer["system"]) == fl.bench().evolve({"finger.kind": "rigid", "plate.q": 460.0})


def test_retuned_gains_print_without_the_loops():
    said = repr(fl.retune(fl.bench()))
    assert said.startswith("Retuned(kp=0, ")
    assert "ki=" in said and "sensitivity_peak=" in said
    assert "System" not in said and said.endswith("loops=3)")


@pytest.mark.parametrize("words", [("--preset", "paper"), ("--preset", "bench", *HELD)], ids=["paper", "bench"])
def test_clamping_alone_is_no_ringing(frictionloop, words):
    """The set-point of paper() is out of reach half of the time; the loop is stable all the same."""
    answer = frictionloop("simulate", "--duration-s", "2", *words, "--json").json()
    assert answer["ringing"]["how"] == "calm" and not answer["rings_alone"]


def test_a_run_that_is_all_reversal_scores_nothing(frictionloop):
    answer = frictionloop("simulate", "--preset", "bench", "--duration-s", "0.02", "--out", "run.h5")
    assert (answer.code, answer.err) == (0, "")
    assert "mN rms" not in answer.out and re.search(r"\bnan\b", answer.out) is None
    assert not fl.load("run.h5").scored.any()


def test_plot_has_a_panel_for_everything_that_moves(frictionloop):
    run = fl.simulate(fl.bench().evolve(fl.RETUNED), 4.0)
    figure = figure_of(run)
    labels = [axes.get_ylabel().split("\n")[0] for axes in figure.axes]
    assert labels == ["force (N)", "vibration", "position", "speed", "load"]
    low, high = figure.axes[0].get_ylim()
    counted = run.f_a.values[run.scored.values]
    assert low <= counted.min() < counted.max() <= high
    assert [text.get_text() for text in figure.legends[0].get_texts()][-1] == "not scored"


def test_plot_of_a_long_run_keeps_the_extremes(frictionloop):
    run = fl.simulate(fl.bench(), 10.0)
    force, *_ = [line.get_ydata() for line in figure_of(run).axes[0].lines if "force on the finger" in line.get_label()]
    assert force.size < run.time.size
    assert (force.min(), force.max()) == (run.f_a.min(), run.f_a.max())
    assert np.isin(force, run.f_a.values).all()
    assert frictionloop(*SHORT, "--plot", "run.svg").code == 0
    assert Path("run.svg").stat().st_size < 3e6


@pytest.mark.slow
def test_a_loop_that_rings_once_its_finger_is_moist_is_found():
    gains = {"controller.kp": 0.02, "controller.ki": 60.0, "sensor.q": 40.0, "finger.slip_length_um": 0.0}
    gains |= {"setpoint.offset_n": 0.6, "setpoint.amplitude_n": 0.3}
    occluded = 1.0 - math.exp(-30.0 / fl.bench().friction.occlusion_s)
    loops = [fl.linearise(fl.bench().evolve(gains), force_n=0.6, occluded=each) for each in (0.0, occluded)]
    assert [loop.is_stable() for loop in loops] == [True, False]
    found = fl.diagnose(fl.simulate(fl.bench().evolve(gains), 30.0)).ringing
    assert (found.how, found.dry, found.where.occluded) == ("unstable", False, pytest.approx(occluded))
