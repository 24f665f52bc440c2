"""The spectrum of a finger's friction: against simulated runs, white noise, and load alone."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.loop_elements import linearise_contact
from studies.causes import mean_occlusion
from studies.friction_spectrum import log_limit_psd, power_of, stretch_psd

BENCH = fl.bench().evolve({**fl.RETUNED, "motion.stroke_mm": 240.0, "setpoint": fl.Constant(offset_n=0.6)})


def test_the_spectrum_says_what_a_linear_loop_leaves():
    frequency_hz, (density, _) = log_limit_psd(BENCH, 11.0, 7, 1.0)
    loop = fl.linearise(BENCH, force_n=0.6, occluded=mean_occlusion(BENCH, 1.0, 11.0))
    lag = linearise_contact(BENCH, 0.6).response(frequency_hz)
    left = np.abs(loop.responses(frequency_hz)["S"] * lag) ** 2 * 0.36 * density
    run = fl.simulate(BENCH, 11.0, 7)
    scored = run["scored"].values & (run["time"].values >= 1.0)
    # Lines of each segment are taken out, and friction moves by a tenth: first order is good to some per cent.
    assert np.sqrt(power_of(frequency_hz, left, 2500.0)) == pytest.approx(fl.rms_error(run, scored), rel=0.1)


def test_density_of_white_noise_and_of_load_alone():
    rng = np.random.default_rng(1)
    parts = [np.arange(0, 20_000), np.arange(30_000, 60_000)]
    frequency_hz, psd = stretch_psd(rng.normal(0.0, 0.1, 60_000), parts, 5000.0)
    # Above 500 Hz a band holds 40 frequencies or more, of some six segments: a scatter of 1/sqrt(40 * 6/1.5) = 8 %.
    high = frequency_hz > 500.0
    assert psd[high] == pytest.approx(2 * 0.1**2 / 5000.0, rel=0.25)
    assert psd[high].mean() == pytest.approx(2 * 0.1**2 / 5000.0, rel=0.04)
    assert np.all(np.diff(frequency_hz) > 0)
    # If only the load moves, a controller that is told it has nothing left to do.
    only = {"friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "motion.tremor_um": 0.0}
    _, (left_in, fed) = log_limit_psd(BENCH.evolve(only), 3.0, 7, 0.5)
    assert fed.sum() < 1e-12 * left_in.sum()
