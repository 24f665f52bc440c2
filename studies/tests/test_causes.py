"""Residuals by cause: pairs of runs, squares that add up in a linear loop, frequency bands that add up always."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

import frictionloop as fl
from frictionloop.loop.companion_runs import plain_stroke
from studies import causes
from studies.residual import residual_by_cause
from studies.residual_bands import band_rms, residual_bands

SHORT = {"duration_s": 1.5, "score_from_s": 0.5}
BENCH = fl.bench().evolve({**fl.RETUNED, "motion.stroke_mm": 240.0})


def split(system, **more):
    return residual_by_cause(system, progress=False, **SHORT | more)


@pytest.mark.parametrize("cause", ["tangential tremor", "normal tremor", "roughness", "load drift", "sensor noise"])
def test_a_cause_that_is_absent_is_one_taken_away(cause):
    gone = causes.without(BENCH, [cause])
    found = split(BENCH.evolve(gone), causes=[cause])
    assert found["all"].values == found["without"].sel(cause=cause).values
    whole = split(BENCH, causes=[cause])
    assert whole["without"].sel(cause=cause).values == found["all"].values
    assert whole["all"].values != found["all"].values
    assert whole["alone"].sel(cause=cause).values != whole["silent"].values


def test_runs_are_those_of_simulate_and_squares_average_over_seeds():
    found = split(BENCH, seeds=[3, 8], causes=["roughness"])
    still = {"friction.roughness_rms": 0.0}
    for name, system in (("all", BENCH), ("without", BENCH.evolve(still))):
        runs = [fl.simulate(system, 1.5, seed) for seed in (3, 8)]
        squares = [fl.rms_error(run, run["scored"].values & (run["time"].values >= 0.5)) ** 2 for run in runs]
        assert found[name].values.item() == pytest.approx(math.sqrt(np.mean(squares)), rel=1e-9)
    paths = ("friction.roughness_rms", "motion.tremor_um")
    people = [{paths[0]: 0.05, paths[1]: 30.0}, {paths[0]: 0.0, paths[1]: 60.0}]
    both = split(BENCH, fingers=people, causes=["roughness"])
    assert both["cost"].values[0, 1] == 0.0 < both["cost"].values[0, 0]


@pytest.mark.parametrize("two", [("set-point", "disturbance")])
def test_squares_of_independent_causes_add_up_in_a_linear_loop(two):
    """1 mN of 3 and of 7 Hz around 0.4 N, whole periods: each leaves |S| A/sqrt 2, and they do not see each other."""
    small = 1e-3
    system = fl.paper().evolve(
        {
            "setpoint": fl.Sine(offset_n=0.4, amplitude_n=small, frequency_hz=3.0),
            "disturbance": fl.Sine(offset_n=0.0, amplitude_n=small, frequency_hz=7.0),
            "sensor.noise_rms_n": 0.0,
            "controller.kp": 0.2,
            "controller.ki": 60.0,
        }
    )
    found = split(system, duration_s=3.0, score_from_s=1.0, causes=two)
    loop = fl.linearise(system, force_n=0.4).responses([3.0, 7.0])
    told = np.abs([1.0 - loop["f_a_from_f_r"][0], loop["f_a_from_d"][1]]) * small / math.sqrt(2)
    assert found["alone"].values[:, 0] == pytest.approx(told, rel=2e-3)
    assert found["cost"].values[:, 0] == pytest.approx(told, rel=2e-3)
    whole2 = found["all"].values ** 2
    assert np.sum(found["alone"].values ** 2, axis=0) == pytest.approx(whole2, rel=2e-3)
    assert found["silent"].values == pytest.approx(0.0, abs=1e-9)
    # What is left over is the loop's own curvature, far below either.
    assert abs(found["left_over_costs"].values) < 0.05 * found["all"].values
    assert abs(found["left_over_alone"].values) < 0.05 * found["all"].values


def test_springs_that_follow_at_once_are_none():
    quiet = BENCH.evolve({"sensor.noise_density_n_rthz": 0.0, "sensor.adc_bits": 32})
    at_once = quiet.evolve(causes.without(quiet, ["resonance"]))
    assert at_once.controller.model.resonance_hz == 0.0
    none = quiet.evolve({"sensor.kind": "lowpass", "sensor.noise_rms_n": 0.0, "controller.model.resonance_hz": 0.0})
    runs = [fl.simulate(system, 1.0, 4) for system in (at_once, none)]
    assert none.sensor.cutoff_hz == at_once.sensor.cutoff_hz
    assert np.max(np.abs(runs[0]["f_a"] - runs[1]["f_a"])) < 1e-4
    assert fl.rms_error(runs[0]) == pytest.approx(fl.rms_error(runs[1]), rel=1e-4)


def test_a_notch_without_a_resonance_undoes_none():
    system = BENCH.evolve({"controller.kind": "notch_pi", "controller.notch_hz": 120.0, "controller.kp": 2.0})
    told = system.evolve(causes.without(system, ["resonance", "misjudged resonance"])).controller
    assert (told.kind, told.kp, told.ki) == ("filtered_pi", 2.0, system.controller.ki)
    rate_hz = system.controller.rate_hz
    w = 2.0 * rate_hz * math.tan(math.pi * 120.0 / rate_hz)  # prewarped
    width = system.controller.notch_width
    num, den = signal.bilinear([w * w], [1.0, 2.0 * width * w, w * w], rate_hz)
    assert told.sections[0] == pytest.approx([*num, *den[1:]], rel=1e-9)
    sections = {"controller.kind": "filtered_pi", "controller.sections": told.sections}
    assert "resonance" not in causes.causes_of(BENCH.evolve(sections))


def test_occlusion_goes_and_its_mean_stays():
    dry = BENCH.evolve(causes.without(BENCH, set(causes.DISTURBANCES) - {"occlusion"}))
    held = dry.evolve(causes.without(dry, ["occlusion"], 1.0, 11.0))
    scored = slice(5000, None)
    limits = [plain_stroke(each, 0.0, 11.0)["limit"].values[scored] for each in (dry, held)]
    assert np.ptp(limits[1]) < 1e-9 < np.ptp(limits[0])
    assert limits[0].mean() == pytest.approx(limits[1].mean(), rel=1e-4)


def test_what_can_be_taken_away_depends_on_the_system():
    assert causes.causes_of(fl.paper()) == ("set-point", "disturbance", "sensor noise", "saturation", "unknown finger")
    assert set(causes.CAUSES) - set(causes.causes_of(fl.bench())) == {"disturbance"}
    steps = fl.Steps(times_s=(0.0, 1.0, 1.5), levels_n=(0.3, 0.4, 0.8))
    held = fl.bench().evolve(causes.without(fl.bench().evolve({"setpoint": steps}), ["set-point"], 1.0, 2.0))
    assert held.setpoint == fl.Constant(offset_n=held.setpoint.offset_n)
    assert held.setpoint.offset_n == pytest.approx(0.6)
    off = BENCH.evolve({"controller.model.resonance_hz": 138.0, "controller.model.resonance_q": 15.0})
    found = off.evolve(causes.without(off, ["misjudged resonance"])).sensor
    assert (found.resonance_hz, found.q) == (138.0, 15.0)
    known = BENCH.evolve({"motion.load_n": 0.7, "friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0})
    model = known.evolve(causes.without(known, ["unknown finger"])).controller.model
    assert model.nominal_n == pytest.approx(0.95 * 1.4**0.9)
    stronger = BENCH.evolve(causes.without(BENCH, ["saturation"]))
    assert stronger.plate.max_amplitude_um == stronger.controller.model.max_amplitude_um == 5.0


@given(st.integers(0, 2**31), st.lists(st.integers(1, 400), min_size=1, max_size=4))
def test_bands_add_up_to_the_whole(seed, lengths):
    rng = np.random.default_rng(seed)
    scored = np.concatenate([np.r_[np.zeros(3, bool), np.ones(length, bool)] for length in lengths])
    residual = rng.normal(0.3, 1.0, scored.size)
    bands = band_rms(residual, scored, 1000.0, np.array([5.0, 60.0, 250.0]))
    assert np.sum(bands**2) == pytest.approx(np.mean(residual[scored] ** 2), rel=1e-9)


@pytest.mark.parametrize(("frequency_hz", "band"), [(2.0, 0), (10.3, 1), (33.3, 2), (145.0, 3), (800.0, 4)])
def test_a_sine_is_in_its_band(frequency_hz, band):
    time = np.arange(20_000) / 5000.0
    sine = np.sin(2 * np.pi * frequency_hz * time + 0.4)
    found = band_rms(sine, np.ones(time.size, bool), 5000.0, np.array([5.0, 15.0, 60.0, 250.0]))
    assert found[band] == pytest.approx(math.sqrt(0.5), rel=0.01)
    assert np.delete(found, band).max() < 0.05


def test_bands_of_a_run_add_up_to_its_rms():
    people = [{"motion.tremor_um": 30.0}, {"motion.tremor_um": 60.0}]
    found = residual_bands(BENCH, people, 1.5, 3, score_from_s=0.5)
    whole = split(BENCH, fingers=people, seeds=[3], causes=["roughness"])["all"]
    assert found["all"].values == pytest.approx(whole.values, rel=1e-9)
    assert found["high_hz"].values.tolist() == [5.0, 15.0, 60.0, 250.0, 2500.0]
