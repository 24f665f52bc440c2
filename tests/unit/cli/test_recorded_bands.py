"""What is left of a recorded disturbance below and above the frequency from which on the loop makes it larger."""

from __future__ import annotations

import json
from contextlib import nullcontext

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis import operating_band
from frictionloop.analysis.levels import at_levels
from frictionloop.cli.recorded_bands import amplified_from_hz, lines
from frictionloop.cli.scores import metric_rows
from frictionloop.parameters.still import STILL

RATE_HZ = 5000.0


def run_of(*tones_hz, **changes):
    time = np.arange(5000) / RATE_HZ
    values_n = 2e-3 * sum((np.sin(2 * np.pi * each * time) for each in tones_hz), start=0 * time)
    signals = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Samples(values_n=values_n, rate_hz=RATE_HZ)}
    return fl.simulate(fl.feasible().evolve(signals | changes), 1.0)


def by_band(run, mask, split_hz):
    return tuple(fl.disturbance_left_by_band(run, [0.0, split_hz, np.inf], mask).values)


@pytest.mark.parametrize(("kp", "ki"), [(10.0, 2.0), (3.0, 50.0)])
def test_the_parts_are_those_of_the_linear_loop(kp, ki):
    low_hz, high_hz = 20.0, 1000.0
    run = run_of(low_hz, high_hz, **{"controller.kp": kp, "controller.ki": ki})
    settled = run.time.values >= 0.2
    split_hz = amplified_from_hz(run, settled)
    assert low_hz < split_hz < high_hz
    steady = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Constant()}
    loop = operating_band(fl.feasible().evolve({**steady, "controller.kp": kp, "controller.ki": ki}))[0]
    response = loop.frequency_response([low_hz, 0.98 * split_hz, 1.02 * split_hz, high_hz])
    size = np.abs(response["f_a_from_d"].values)[[0, -1]]
    assert by_band(run, settled, split_hz) == pytest.approx(tuple(size), rel=0.05)
    below, above = np.abs(response["S"].values)[[1, 2]]
    assert below < 1.0 < above


def test_the_parts_are_told_and_add_up_by_their_squares():
    run = run_of(20.0, 1000.0)
    everything = np.ones(run.sizes["time"], bool)
    split_hz = amplified_from_hz(run, everything)
    low, high = by_band(run, everything, split_hz)
    assert low**2 + high**2 == pytest.approx(2 * fl.metrics(run)["disturbance_left"] ** 2, rel=1e-2)
    said = " ".join(lines(run, everything))
    assert (f"Below {split_hz:.3g} Hz {low:.0%} of the recorded variation is left, above {high:.0%}") in said


def test_nothing_is_told_without_a_recording():
    run = run_of(20.0, disturbance=fl.Sine(amplitude_n=0.1))
    assert lines(run, np.ones(run.sizes["time"], bool)) == []


def test_without_feedback_all_is_left_and_what_entered_is_told():
    run = run_of(20.0, **{"controller.kind": "lookup"})
    said = " ".join(lines(run, np.ones(run.sizes["time"], bool)))
    assert f"the disturbance varies by {1e3 * run.d.values.std():.3g} mN rms" in said
    assert said.endswith("of the disturbance all is left, at every frequency.")
    assert fl.metrics(run)["disturbance_left"] == pytest.approx(1.0, abs=1e-9)


def test_a_recording_without_a_fast_part_says_so():
    run = run_of(20.0)
    settled = run.time.values >= 0.2
    assert "The recording has next to nothing above " in " ".join(lines(run, settled))


def test_a_recording_without_a_slow_part_says_so_and_what_entered():
    run = run_of(1000.0)
    settled = run.time.values >= 0.2
    said = " ".join(lines(run, settled))
    assert "The recording has next to nothing below " in said
    force = run.f_a.values[settled]
    assert f"the disturbance varies by {1e3 * run.d.values[settled].std():.3g} mN rms" in said
    assert f"f_a varies by {1e3 * force.std():.3g} mN rms about {force.mean():.3g} N" in said


def test_of_a_finger_without_variation_nothing_is_said_to_be_its_own():
    time = np.arange(5000) / RATE_HZ
    varies = fl.Samples(values_n=0.03 * np.sin(2 * np.pi * 20 * time), rate_hz=RATE_HZ)
    bench = fl.bench().evolve({**fl.RETUNED, "setpoint": fl.Constant(offset_n=0.5), "disturbance": varies})
    for system, own in ((bench, True), (bench.evolve(STILL), False)):
        run = fl.simulate(system, 1.0)
        said = " ".join(lines(run, run.scored.values))
        assert "of the recorded variation is left" in said or "next to nothing" in said
        assert ("the finger's own" in said) is own


def test_what_is_too_large_for_newtons_is_not_split(tmp_path):
    path = tmp_path / "slide.csv"
    path.write_text("time_s,F\n" + "".join(f"{k / 1000},{700 + 50 * (k % 2)}\n" for k in range(1001)))
    recording = fl.Recording(path=str(path), column="F", remove_mean=True)
    with pytest.warns(fl.SignalWarning, match="is up to 750 N before its mean is removed"):
        run = run_of(**{"disturbance": recording})
    said = " ".join(lines(run, np.ones(run.sizes["time"], bool)))
    assert said == (
        "From which frequency on feedback makes a variation larger is not told while it is not clear what the "
        "recording is."
    )


@pytest.mark.slow
def test_gains_that_ring_on_a_recorded_set_point_are_told(frictionloop, tmp_path):
    t = np.arange(2001) / 1000
    force_n = 0.6 + 0.1 * np.sin(2 * np.pi * t)
    np.savetxt(tmp_path / "wanted.csv", np.c_[t, force_n], delimiter=",", header="t [s],force [N]", comments="")
    flags = ("--setpoint.kind", "recording", "--setpoint.path", "wanted.csv", "--setpoint.column", "force")
    run = ("simulate", "--preset", "bench", *flags, "--duration-s", "2", "--json")
    ringing = json.loads(frictionloop(*run).out)["ringing"]
    assert ringing["held"]
    assert ringing["band"]["low_n"] == pytest.approx(force_n.min(), rel=1e-6)
    held = [word for name, value in ringing["held"].items() for word in (f"--{name}", f"{value}")]
    assert json.loads(frictionloop(*run, *held).out)["ringing"] is None


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


def slid_under(mean_n):
    bench = fl.bench().evolve({"setpoint": fl.Constant(offset_n=0.5)} | fl.RETUNED)
    values_n = mean_n + 0.03 * np.sin(2 * np.pi * 3 * np.arange(5000) / RATE_HZ)
    return bench.evolve({"disturbance": fl.Samples(values_n=values_n, rate_hz=RATE_HZ)})


@pytest.mark.parametrize(("mean_n", "reached"), [(3.0, False), (0.0, True)])
def test_what_no_vibration_makes_up_for_is_said_in_place_of_a_frequency(mean_n, reached):
    with nullcontext() if reached else pytest.warns(fl.SignalWarning, match="has a mean of 3 N"):
        run = fl.simulate(slid_under(mean_n), 1.0)
    kept = run.scored.values
    said, touch = " ".join(lines(run, kept)), " ".join(map(str, metric_rows(fl.metrics(run))))
    most_n = float(np.median((run.limit - run.floor).values[kept]))
    beyond = f"do nothing about it 100% of the time: vibration lowers the friction by {most_n:.3g} N at most. "
    assert (beyond + "The disturbance goes from 2.9" in said) is not reached
    assert ("Hz" in said) is reached
    assert ("says little where most commands are clamped" in touch) is not reached
    assert ("er to touch" in touch) is reached


def test_what_the_start_adds_is_told_where_it_counts():
    # At the first samples the loop has not acted yet, and d is far from its mean there.
    time = np.arange(3000) / RATE_HZ
    values_n = 0.02 * np.sin(2 * np.pi * 5.0 * time) + 0.08 * (time < 0.01)
    signals = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Samples(values_n=values_n, rate_hz=RATE_HZ)}
    run = fl.simulate(fl.feasible().evolve(signals), 0.6)
    everything = np.ones(run.sizes["time"], bool)
    left = fl.metrics(run, run.time.values >= 0.1)["disturbance_left"]
    assert left < fl.metrics(run)["disturbance_left"] / 1.05
    said = " ".join(lines(run, everything))
    assert f"Without the first 0.1 s, in which the loop begins, {left:.3g} of the disturbance is left" in said
    assert "Without the first" not in " ".join(lines(run, run.time.values >= 0.1))
    assert "Without the first" not in " ".join(lines(run_of(20.0), everything[:1].repeat(5000)))


def test_the_start_of_the_run_and_a_mean_that_is_off_are_told_of_the_force():
    run = run_of(20.0, **{"controller.kp": 3.0, "controller.ki": 2.0})
    said = " ".join(lines(run, np.ones(run.sizes["time"], bool)))
    rest_mn = 1e3 * float(run.f_a.values[run.time.values >= 0.1].std())
    assert f"without the first 0.1 s by {rest_mn:.3g} mN" in said
    mean_mn = 1e3 * float((run.f_r - run.f_a).values.mean())
    assert f"Its mean is {mean_mn:.3g} mN below that of the set-point, which counts in rms_error" in said
    tight = run_of(20.0, **{"controller.kp": 3.0, "controller.ki": 200.0})
    assert "Its mean is" not in " ".join(lines(tight, tight.time.values >= 0.3))


def test_a_recording_that_was_not_cut_says_so(frictionloop, tmp_path):
    np.savetxt(tmp_path / "s.csv", 0.01 * np.sin(np.arange(2000) / 9), header="Ft [N]", comments="")
    flags = ("kind", "recording", "path", "s.csv", "column", "Ft", "rate_hz", "1000")
    given = [f"--disturbance.{each}" if k % 2 == 0 else each for k, each in enumerate(flags)]
    given = ["simulate", "--preset", "feasible", "--duration-s", "1", *given]
    assert "used uncut: landing, rests and lifting count" in " ".join(frictionloop(*given).out.split())
    assert "uncut" not in frictionloop(*given, "--disturbance.stop_s", "1.5").out


def test_the_friction_that_a_recording_comes_on_and_where_its_file_ends_are_told(frictionloop, tmp_path):
    np.savetxt(tmp_path / "s.csv", 0.3 + 0.02 * np.sin(np.arange(400) / 3), header="Ft [N]", comments="")
    flags = ("kind", "recording", "path", "s.csv", "column", "Ft", "rate_hz", "100", "remove_mean", "true")
    given = [f"--disturbance.{each}" if k % 2 == 0 else each for k, each in enumerate(flags)]
    fixed = ("--setpoint.kind", "constant", "--split-hz", "2", "--setpoint.offset_n")
    given = ["simulate", "--preset", "feasible", "--duration-s", "3", *given, *fixed]
    said = " ".join(frictionloop(*given, "0.5").out.split())
    assert "on a finger of friction.nominal_n = 0.8 N, for which the lookup table is made" in said
    assert "The mean in the file is 0.3 N, the zero of its sensor included. Has the recorded finger less" in said
    known = " ".join(frictionloop(*given, "0.5", "--friction.nominal_n", "0.9").out.split())
    assert "sensor included." in known and "Has the recorded finger less" not in known
    near = " ".join(frictionloop(*given, "0.5", "--disturbance.scale", "2").out.split())
    assert "The mean in the file is 0.6 N, the zero of its sensor included." in near
    other = " ".join(frictionloop(*given, "0.3", "--friction.nominal_n", "0.6").out.split())
    assert "made for 0.8 N, another finger: --controller.model.nominal_n 0.6 makes it for this one" in other
    assert "above 2 Hz (the file ends at 50 Hz)" in said
    assert "The recording ends at 50 Hz, half its rate; from 604 Hz on feedback makes a variation larger." in said
    assert "comes on a finger" not in frictionloop(*given, "0.5", "--controller.kind", "lookup").out
