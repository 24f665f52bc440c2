"""The computed limit of a finger: its spectrum against simulated runs, the limit against loops that exist."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design import reachable
from frictionloop.design.causes import mean_occlusion
from frictionloop.design.elements import linearise_contact

BENCH = fl.bench().evolve({**fl.RETUNED, "motion.stroke_mm": 240.0, "setpoint": fl.Constant(offset_n=0.6)})


@pytest.fixture(scope="module")
def left_by_pi():
    """What the re-tuned PI leaves by |S|^2 over the spectrum, and in a run, N."""
    frequency_hz, (density, _) = reachable.log_limit_psd(BENCH, 11.0, 7, 1.0)
    loop = fl.linearise(BENCH, force_n=0.6, occluded=mean_occlusion(BENCH, 1.0, 11.0))
    lag = linearise_contact(BENCH, 0.6).response(frequency_hz)
    left = np.abs(loop.responses(frequency_hz)["S"] * lag) ** 2 * 0.36 * density
    run = fl.simulate(BENCH, 11.0, 7)
    scored = run["scored"].values & (run["time"].values >= 1.0)
    peak = loop.margins().sensitivity_peak
    return np.sqrt(reachable.power_of(frequency_hz, left, 2500.0)), fl.rms_error(run, scored), peak


def test_the_spectrum_says_what_a_linear_loop_leaves(left_by_pi):
    by_spectrum, by_run, _ = left_by_pi
    # Lines of each segment are taken out, and friction moves by a tenth: first order is good to some per cent.
    assert by_spectrum == pytest.approx(by_run, rel=0.1)


def test_the_limit_is_below_a_loop_of_the_same_peak_and_falls_with_the_peak(left_by_pi):
    by_spectrum, _, peak = left_by_pi
    peaks = (peak, 1.2 * peak, 3.0)
    found = reachable.least_residual(BENCH, [{}], seed=7, peaks=peaks, levels_n=[0.6])
    least = found["residual_rms_n"].sel(measured="force").values[:, 0]
    assert least[0] < by_spectrum
    assert np.all(np.diff(least) < 0)
    assert np.all(least < found["open_rms_n"].sel(measured="force").values)
    fed = found["open_rms_n"].sel(measured="force and load").values
    assert fed < found["open_rms_n"].sel(measured="force").values


def test_without_lag_the_limit_is_in_proportion_to_the_force():
    slider = BENCH.evolve({"finger.contact": "slider"})
    found = [
        reachable.least_residual(slider, [{}], 3.0, 7, peaks=[1.7], levels_n=levels)["residual_rms_n"].values
        for levels in ([0.4], [0.8], [0.4, 0.8])
    ]
    assert found[1] == pytest.approx(2.0 * found[0], rel=1e-3)
    assert found[2] == pytest.approx(np.sqrt((found[0] ** 2 + found[1] ** 2) / 2.0), rel=1e-9)


def test_density_of_white_noise_and_of_load_alone():
    rng = np.random.default_rng(1)
    parts = [np.arange(0, 20_000), np.arange(30_000, 60_000)]
    frequency_hz, psd = reachable.stretch_psd(rng.normal(0.0, 0.1, 60_000), parts, 5000.0)
    # Above 500 Hz a band holds 40 frequencies or more, of some six segments: a scatter of 1/sqrt(40 * 6/1.5) = 8 %.
    high = frequency_hz > 500.0
    assert psd[high] == pytest.approx(2 * 0.1**2 / 5000.0, rel=0.25)
    assert psd[high].mean() == pytest.approx(2 * 0.1**2 / 5000.0, rel=0.04)
    assert np.all(np.diff(frequency_hz) > 0)
    # If only the load moves, a controller that is told it has nothing left to do.
    only = {"friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "motion.tremor_um": 0.0}
    _, (left_in, fed) = reachable.log_limit_psd(BENCH.evolve(only), 3.0, 7, 0.5)
    assert fed.sum() < 1e-12 * left_in.sum()


def test_a_force_out_of_reach_has_no_limit_and_wrong_friction_is_refused():
    found = reachable.least_residual(BENCH, [{"friction.nominal_n": 0.3}], 2.0)
    assert np.isnan(found["residual_rms_n"].values).all()
    with pytest.raises(fl.FrictionloopError, match=r'friction\.kind = "gaussian": must be "finger"'):
        reachable.least_residual(fl.paper(), [{}])
