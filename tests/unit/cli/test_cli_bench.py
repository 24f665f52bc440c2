"""``frictionloop simulate --preset bench``: the device, its finger, and what is said of a loop that rings."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis import operating_band
from frictionloop.cli.flags import PresetName
from frictionloop.parameters import PRESETS
from frictionloop.report.run_figure import figure_of

SHORT = ("simulate", "--preset", "bench", "--duration-s", "1")
HELD = tuple(word for path, gain in fl.RETUNED.items() for word in (f"--{path}", str(gain)))
STEPS = {"setpoint": fl.Steps(times_s=(0.0, 0.4, 0.7), levels_n=(0.5, 0.7, 0.5))}
STEPPED = (
    *("--setpoint.kind", "steps"),
    *("--setpoint.times_s", "[0, 0.4, 0.7]", "--setpoint.levels_n", "[0.5, 0.7, 0.5]"),
)


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")


def test_presets_are_those_of_the_package():
    assert get_args(PresetName) == tuple(PRESETS)


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_runs(frictionloop, name):
    answer = frictionloop("simulate", "--preset", name, "--duration-s", "0.2", "--json").json()
    assert fl.System.from_tree(answer["system"]) == PRESETS[name]()


def test_json_is_the_run_in_python(frictionloop):
    answer = frictionloop(*SHORT, *HELD, "--score-from-s", "0.5", "--seed", "2", "--json").json()
    run = fl.simulate(fl.bench().evolve(fl.RETUNED), 1.0, seed=2)
    mask = (run.time.values >= 0.5) & run.scored.values
    found = answer["metrics"]
    assert found["rms_error"] == fl.rms_error(run, mask)
    assert found["perceptual_index"] == fl.perceptual_index(run, mask)
    assert found["relative_index"] == fl.relative_index(run, mask)
    assert answer["scored"] == mask.mean()
    assert answer["ringing"] is None


def test_score_from_s_does_not_bring_reversals_back(frictionloop):
    # At t = 0 the finger rests at the end of its stroke.
    answer = frictionloop(*SHORT, *HELD, "--json").json()
    run = fl.simulate(fl.bench().evolve(fl.RETUNED), 1.0)
    assert 0 < answer["scored"] == run.scored.values.mean() < 1
    assert answer["metrics"]["rms_error"] == fl.rms_error(run)


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


def test_summary_has_derived_numbers(frictionloop):
    answer = frictionloop(*SHORT, *HELD, "--plate.q", "46", "--sensor.adc_bits", "10", "--motion.speed_mm_s", "50")
    assert (answer.code, answer.err) == (0, "")
    # f/(2 Q); 5 N / 2^10; sqrt(pi/2 1000) 2.3e-6; (2 pi 145)^2 0.4; 200 us and half of 200 us; 1000 N/m at 50 mm/s
    for said in ("cutoff 500 Hz", "ADC step 4.88 mN", "0.0912 mN rms", "0.332 N/um", "300 us", "at most 50 N/s"):
        assert said in answer.out
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= 100


def test_summary_of_the_paper_stays_short(frictionloop):
    out = frictionloop("simulate", "--preset", "feasible", "--duration-s", "0.2").out
    assert "touch" not in out.split("r2_identity")[0]
    assert re.search(r"^finger +rigid *$", out, re.MULTILINE)
    assert "->" not in out
    assert "relative_index" not in out


def test_steps_have_times(frictionloop):
    answer = frictionloop(*SHORT, *HELD, *STEPPED, "--json").json()
    times = fl.step_times(fl.simulate(fl.bench().evolve(fl.RETUNED | STEPS), 1.0))
    assert answer["steps"] == [each._asdict() for each in times]
    assert len(times) == 2
    out = frictionloop(*SHORT, *HELD, *STEPPED).out
    assert f"rise              {1e3 * times[0].rise_s:.3g} ms" in out
    assert f"; {1e3 * times[1].to_63_s:.3g} ms to 63 %; mean of 1 step" in out
    assert "not followed" not in out


def test_steps_that_are_not_followed_are_counted(frictionloop):
    # Without vibration the finger has 0.95 N, far above either level.
    out = frictionloop(*SHORT, *HELD, *STEPPED, "--plate.max_amplitude_um", "0.01").out
    assert re.search(r"^not followed +\d steps? ", out, re.MULTILINE)


def test_the_printed_gains_ring_and_it_is_said(frictionloop):
    answer = frictionloop(*SHORT)
    assert answer.code == 0
    assert "This loop rings near 14" in answer.out  # the resonance at 145 Hz, pulled down by the delay
    assert "of the commands are clamped, the force does not follow." in answer.out
    assert "kp = 10, ki = 2: too much for this sensor, plate and delay." in answer.out
    assert (
        "\nThey hold with Ms up to 2, dry and moist (occluded 100%), at the set-point's levels (0.5 to 0.7 N),"
        in answer.out
    )
    assert "slip length 11.5 um, 20 mm/s, sensor resonance 145 Hz" in " ".join(answer.out.split())
    assert "on slip length 0 um at 10, 20, 80 mm/s. They stop the ringing" in " ".join(answer.out.split())
    gains = re.search(r"^Gains that hold: (.*)$", answer.out, re.MULTILINE)[1]
    held = frictionloop(*SHORT, *gains.split())
    assert "This loop" not in held.out
    assert float(re.search(r"r2_identity +(\S+)", held.out)[1]) > 0.5


def test_retuned_gains_print_without_the_loops():
    said = repr(fl.retune(fl.bench()))
    assert said.startswith("Retuned(kp=0, ")
    assert "ki=" in said and "sensitivity_peak=" in said
    assert "System" not in said and said.endswith("loops=3)")


def test_ringing_as_json(frictionloop):
    found = frictionloop(*SHORT, "--json").json()["ringing"]
    assert not found["stable"]
    assert 130 < found["frequency_hz"] < 150
    assert (found["kp"], found["ki"]) == (10, 2)
    where = ", slip length 11.5 um, 20 mm/s, sensor resonance 145 Hz"
    levels = {"low_n": pytest.approx(0.5), "high_n": pytest.approx(0.7)}
    assert found["band"] == levels | {
        "dry_and_moist": True,
        "occluded": 1.0,
        "where": where,
        "out_of_reach_n": [],
    }
    fast = fl.bench().evolve({**found["held"], "motion.speed_mm_s": 80.0})
    assert all(each.margins().stable for each in operating_band(fast, occluded=(0.0, 1.0)))
    system = fl.bench().evolve(found["held"])
    assert fl.linearise(system).margins().stable


@pytest.mark.parametrize("words", [("--preset", "paper"), ("--preset", "bench", *HELD)], ids=["paper", "bench"])
def test_clamping_alone_is_no_ringing(frictionloop, words):
    """The set-point of paper() is out of reach half of the time; the loop is stable all the same."""
    assert frictionloop("simulate", "--duration-s", "2", *words, "--json").json()["ringing"] is None


@pytest.mark.parametrize("kp", [0.15, 0.19])
def test_a_loop_close_to_ringing(frictionloop, kp):
    out = frictionloop(*SHORT, "--controller.kp", kp, "--controller.ki", "2").out
    assert ("close to ringing" in out or "This loop rings" in out) and "Gains that hold" in out


def test_a_run_that_is_all_reversal_has_dashes(frictionloop):
    answer = frictionloop("simulate", "--preset", "bench", "--duration-s", "0.02", "--out", "run.h5")
    assert (answer.code, answer.err) == (0, "")
    assert re.search(r"^scored +0 % +all periods are at a reversal", answer.out, re.MULTILINE)
    assert "rms_error" not in answer.out
    assert re.search(r"\bnan\b", answer.out) is None
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


def test_a_run_says_that_it_is_one_contact_and_speed_where_a_check_looks_at_others(frictionloop):
    said = frictionloop(
        "simulate", "--preset", "bench", "--duration-s", "1", "--controller.kp", "0", "--controller.ki", "60"
    )
    command = "frictionloop design check --preset bench --controller.kp 0 --controller.ki 60"
    assert f"This run is at 20 mm/s with slip length 11.5 um; `{command}` looks at others" in " ".join(said.out.split())
    alone = ("--friction.occlusion_ratio", "1", "--friction.moist_loss", "0", "--finger.slip_length_um", "0")
    gains = ("--controller.kp", "0", "--controller.ki", "20")
    still = frictionloop("simulate", "--preset", "bench", "--duration-s", "1", *gains, *alone)
    assert "check --preset bench --controller.kp 0 --controller.ki 20 --finger.slip_length_um 0` looks at" in " ".join(
        still.out.split()
    )
    moister = frictionloop("simulate", "--preset", "bench", "--duration-s", "1", *gains, "--friction.moist_loss", "0.2")
    assert "--controller.ki 20 --friction.moist_loss 0.2` looks at others" in " ".join(moister.out.split())
    wide = (
        "--setpoint.offset_n",
        "0.6",
        "--setpoint.amplitude_n",
        "0.3",
        "--sensor.q",
        "40",
        "--finger.slip_length_um",
        "0",
    )
    gains = ("--sensor.resonance_hz", "170", "--controller.kp", "0.062", "--controller.ki", "134")
    rings = " ".join(frictionloop("simulate", "--preset", "bench", "--duration-s", "4", *wide, *gains).out.split())
    assert "slip length 0 um, where the linear loop is unstable at 0.3, 0.6, 0.9 N: it rings, too little to" in rings
    assert not fl.linearise(fl.bench().evolve({path.removeprefix("--"): value for path, value in zip(
        (*wide, *gains)[::2], (0.6, 0.3, 40.0, 0.0, 170.0, 0.062, 134.0), strict=True)})).is_stable()  # fmt: skip
    for other in (("--controller.kind", "lookup"), ("--preset", "feasible")):
        args = other if "--preset" in other else ("--preset", "bench", *other)
        assert "design check" not in frictionloop("simulate", *args, "--duration-s", "1").out


@pytest.mark.slow
def test_a_loop_that_rings_once_its_finger_is_moist_is_told(frictionloop):
    gains = {"controller.kp": 0.02, "controller.ki": 60.0, "sensor.q": 40.0, "finger.slip_length_um": 0.0}
    gains |= {"setpoint.offset_n": 0.6, "setpoint.amplitude_n": 0.3}
    flags = [word for path, value in gains.items() for word in (f"--{path}", f"{value}")]
    occluded = 1.0 - math.exp(-30.0 / fl.bench().friction.occlusion_s)
    loops = [fl.linearise(fl.bench().evolve(gains), force_n=0.6, occluded=each) for each in (0.0, occluded)]
    assert [loop.is_stable() for loop in loops] == [True, False]
    said = " ".join(frictionloop("simulate", "--preset", "bench", "--duration-s", "30", *flags).out.split())
    assert f"with a finger {occluded:.0%} occluded as at its end: it rings, too little to stand out here" in said
    short = frictionloop("simulate", "--preset", "bench", "--duration-s", "0.5", *flags).out
    assert "linear loop is unstable" not in short


def test_a_delay_beyond_the_linear_analysis_is_told_where_commands_are_clamped(frictionloop):
    out = frictionloop("simulate", "--preset", "bench", "--controller.delay_s", "0.4", "--duration-s", "1").out
    assert "-> 400 ms with half the hold" in out
    assert "of the commands are clamped. Whether this loop rings is not known: a delay of 2000" in " ".join(out.split())
    quick = frictionloop("simulate", "--preset", "bench", "--controller.delay_s", "4e-4", "--duration-s", "1").out
    assert "-> 500 us with half the hold" in quick and "is not known" not in quick


def test_a_sensor_without_a_resonance_needs_no_law_with_a_notch(frictionloop):
    said = " ".join(
        frictionloop(
            "simulate", "--preset", "feasible", "--controller.delay_s", "2e-4", "--duration-s", "1"
        ).out.split()
    )
    assert "This loop rings" in said and "Gains that hold:" in said and "notch" not in said
    with_springs = " ".join(frictionloop("simulate", "--preset", "bench", "--duration-s", "2").out.split())
    assert "its law has a notch" in with_springs


def test_a_loop_that_rings_on_a_moist_finger_alone_says_so(frictionloop):
    old = {"controller.kp": 0.062, "controller.ki": 134.0}
    fast = fl.bench().evolve(old | {"motion.speed_mm_s": 80.0})
    dry, moist = ([each.is_stable() for each in fl.operating_band(fast, occluded=(w,))] for w in (0.0, 1.0))
    assert all(dry) and not all(moist)
    gains = [word for path, value in old.items() for word in (f"--{path}", f"{value:g}")]
    words = ("simulate", "--preset", "bench", *gains, "--motion.speed_mm_s", "80", "--duration-s", "10")
    said = " ".join(frictionloop(*words).out.split())
    assert "on a moist finger (occluded 100%), not on one just landed" in said
