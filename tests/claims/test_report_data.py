"""The numbers under the figures, against closed forms and against each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.report.gain_maps import KIS, KPS, at, optimum, spread, useful_range
from frictionloop.report.results import parts
from frictionloop.report.sensor_noise import LEVELS_N, NOISE_READINGS, knee_n
from frictionloop.report.system_comparison import (
    FEASIBLE,
    WORKING,
    at_means,
    compared,
    noise_above_n,
    reachable_share,
    readings,
)


def cut(values, gains=(1.0, 2.0, 4.0, 8.0)):
    return xr.DataArray(np.array(values), {"gain": list(gains)}, "gain")


def test_the_useful_range_is_interpolated_over_the_logarithm():
    found = useful_range(cut([0.96, 1.0, 0.98, 0.9]), step=0.02)
    assert found.low == pytest.approx(2 ** (0.5))
    assert found.high == pytest.approx(4.0)


def test_a_range_without_end_says_so():
    assert useful_range(cut([0.9, 0.99, 1.0, 0.995]), step=0.02).high is None
    assert useful_range(cut([1.0, 0.9, 0.8, 0.7]), step=0.02).low is None


def test_optimum_and_spread():
    fidelity = cut([0.1, 0.5, 0.4, 0.3])
    assert optimum(fidelity)[0] == 2.0
    assert spread(fidelity, 2.0, 8.0) == pytest.approx(0.2)
    assert at(fidelity, 3.9) == 0.4


def test_the_grids_hold_the_gains_of_the_text():
    assert {1.0, 5.0, 10.0, 20.0, 40.0} <= set(KPS.tolist())
    assert {0.1, 2.0, 1e4} <= set(KIS.tolist())
    assert np.all(np.diff(KPS) > 0) and np.all(np.diff(KIS) > 0)


def test_a_noise_reading_and_its_inverse():
    for reading in NOISE_READINGS.values():
        assert reading.level(reading.sigma_n(3e-5)) == pytest.approx(3e-5)
    assert NOISE_READINGS["variance"].sigma_n(1e-4) == pytest.approx(0.01)
    assert NOISE_READINGS["amplitude density"].sigma_n(1e-4) == pytest.approx(5e-3)


def test_the_knee_of_a_known_curve():
    sigma = np.geomspace(1e-6, 1, 200)
    metric = xr.DataArray(1 - sigma[:, None] * [1.0, 1.0, 1.0], {"sigma": sigma}, ("sigma", "seed"))
    assert knee_n(metric, 0.01) == pytest.approx(0.01, rel=1e-2)
    assert knee_n(metric * 0 + 1) is None
    # R2 falls by the power of the noise: on the report's own points, a third apart, its knee is exact.
    square = xr.DataArray(1 - LEVELS_N[:, None] ** 2 * [1.0, 1.0], {"sigma": LEVELS_N}, ("sigma", "seed"))
    assert knee_n(square, 0.013) == pytest.approx(math.sqrt(0.013), rel=1e-6)


def test_noise_above_a_frequency_is_the_rms_of_a_tone():
    time = np.arange(0, 4, 2e-4)
    force = 0.6 + 0.1 * np.sin(2 * np.pi * 50 * time) + 0.02 * np.sin(2 * np.pi * 1000 * time)
    run = xr.Dataset({"f_a": ("time", force)}, {"time": time})
    assert noise_above_n(run) == pytest.approx(0.02 / np.sqrt(2), rel=1e-2)


def test_the_working_reading_is_the_preset():
    assert next(iter(readings())) == WORKING and readings()[WORKING] == fl.paper()
    assert list(compared())[-1] == FEASIBLE and compared()[FEASIBLE] == fl.feasible()


def test_a_held_system_stands_at_its_means():
    still = at_means(fl.paper())
    assert still.setpoint == fl.Constant(offset_n=0.6) and still.disturbance == fl.Constant(offset_n=0.4)


def test_reachable_share():
    assert reachable_share(fl.feasible()) == 1.0
    assert 0 < reachable_share(fl.paper()) < 1


def test_parts_have_names_of_their_own():
    names = [name for name, _ in parts()]
    assert len(set(names)) == len(names)


def test_maps_and_cuts_agree(results):
    for name, fidelity in results.maps.items():
        along = fidelity["r2_identity"].sel(ki=2.0).values
        below_the_limit_cycle = KPS <= 14
        expected = results.over_kp[name]["r2_identity"].values
        # They differ in the number of seeds, at noise that hardly matters.
        assert along[below_the_limit_cycle] == pytest.approx(expected[below_the_limit_cycle], abs=1e-5)


def test_a_map_holds_the_r2_of_a_single_run(results):
    run = results.runs[FEASIBLE][10.0]
    fidelity = results.maps[FEASIBLE]["r2_identity"].sel(kp=10.0, ki=2.0)
    assert float(fidelity) == pytest.approx(fl.r2_identity(run), abs=1e-5)
    assert float(results.maps[FEASIBLE]["r2_bound"]) == pytest.approx(1.0)


def test_nothing_beats_the_bound(results):
    for data in (*results.over_kp.values(), *results.per_sample.values(), *results.over_ki.values()):
        assert float(data["r2_identity"].max()) <= float(data["r2_bound"])


def test_the_simulated_noise_is_the_exact_one_below_the_limit_cycle(results):
    steady = results.steady
    stable = steady["kp_simulated"].values <= 14
    for output in ("f", "u"):
        exact = np.interp(steady["kp_simulated"], steady["kp"], steady[f"exact_{output}"])
        simulated = steady[f"simulated_{output}"].values
        assert simulated[stable] == pytest.approx(exact[stable], rel=0.02)
