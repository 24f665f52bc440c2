"""How far a recorded set-point is followed, against the linear loop."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis import operating_band
from frictionloop.cli.recorded import on_top
from frictionloop.cli.recorded_followed import error_by_band, followed_to_hz, lines

RATE_HZ = 5000.0
TIME_S = np.arange(15000) / RATE_HZ


def run_of(*tones_hz, **changes):
    values_n = 0.5 + 2e-3 * sum((np.sin(2 * np.pi * each * TIME_S) for each in tones_hz), start=0 * TIME_S)
    gains = {"controller.kp": 10.0, "controller.ki": 100.0}
    signals = gains | {"setpoint": fl.Samples(values_n=values_n, rate_hz=RATE_HZ), "disturbance": fl.Constant()}
    run = fl.simulate(fl.feasible().evolve(signals | changes), 3.0)
    return run, run.time.values >= 2.5  # the integrator has settled


@pytest.mark.parametrize(("kp", "ki"), [(10.0, 100.0), (3.0, 50.0)])
def test_the_frequency_and_both_errors_are_those_of_the_linear_loop(kp, ki):
    low_hz, high_hz = 20.0, 1000.0
    gains = {"controller.kp": kp, "controller.ki": ki}
    (low, settled), (high, _) = run_of(low_hz, **gains), run_of(high_hz, **gains)
    to_hz = followed_to_hz(low, settled)
    steady = {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Constant()}
    loop = operating_band(fl.feasible().evolve({**steady, **gains}))[0]
    response = loop.frequency_response([low_hz, 0.98 * to_hz, 1.02 * to_hz, high_hz])["f_a_from_f_r"].values
    decibels = np.abs(20 * np.log10(np.abs(response[[1, 2]])))
    three = 20 * np.log10(np.sqrt(2))
    assert decibels[0] < three < decibels[1]
    found = error_by_band(low, settled, to_hz)[0].share, error_by_band(high, settled, to_hz)[1].share
    assert found == pytest.approx(tuple(np.abs(1 - response[[0, 3]])), rel=0.05)


def test_it_is_said_and_a_part_that_is_not_there_is_left_out():
    run, settled = run_of(20.0)
    to_hz = followed_to_hz(run, settled)
    below, above = error_by_band(run, settled, to_hz)
    assert above.asked_n < 1e-2 * below.asked_n
    said = " ".join(lines(run, settled))
    assert said.startswith(f"The force follows the recorded set-point up to {to_hz:.3g} Hz (linear, within 3 dB")
    assert f"Below that the error varies by {below.share:.0%} of what is asked (rms)." in said
    assert said.endswith(f"the error varies by {1e3 * above.error_n:.3g} mN.")


@pytest.mark.parametrize(
    "changes", [{"setpoint": fl.Sine(offset_n=0.5, amplitude_n=0.1)}, {"controller.kp": 100.0, "controller.ki": 0.0}]
)
def test_nothing_is_said_of_another_set_point_or_a_loop_that_rings(changes):
    run, settled = run_of(20.0, **changes)
    assert lines(run, settled) == []


def test_the_error_is_not_that_of_rows_that_are_not_scored():
    run, settled = run_of(20.0)
    to_hz = followed_to_hz(run, settled)
    kept = settled & ~((run.time.values > 2.7) & (run.time.values < 2.71))
    lifted = run.assign(f_a=run.f_a.where(kept, 0.0))
    found, plain = (error_by_band(each, kept, to_hz)[0].share for each in (lifted, run))
    assert found == pytest.approx(plain, rel=0.05)


def test_of_a_finger_with_its_own_motion_the_flags_are_named_that_still_it():
    array = fl.Samples(values_n=0.5 + 0.1 * np.sin(TIME_S), rate_hz=RATE_HZ)
    said = on_top(fl.bench().evolve({"setpoint": array}))
    assert "drift and roughness count in the error. The recorded setpoint is alone with --motion.tremor_um 0" in said
    assert on_top(fl.feasible().evolve({"setpoint": array})) == ""
