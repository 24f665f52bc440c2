"""The identified disturbance against the ingredients it was made of, and the filter that is fitted to it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictionloop.design.noise_model import fit_shaping, identify_noise
from frictionloop.parameters import bench
from frictionloop.physics.roughness import WAVES

STILL = {
    "motion.load_drift": 0.0,
    "friction.occlusion_ratio": 1.0,
    "friction.moist_loss": 0.0,
    "finger.slip_length_um": 0.0,
}
ROUGH = bench().evolve(STILL | {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0})
TREMBLES = bench().evolve(STILL | {"motion.tremor_um": 0.0, "friction.roughness_rms": 0.0})


def test_roughness_is_one_over_f_of_the_given_rms() -> None:
    found = identify_noise(ROUGH, seeds=range(6))
    f = found.spectrum["frequency"].values
    band = (f > 5) & (f < 100)
    # Mean square (0.05 F)^2 spread as 1/k over WAVES waves; a slider of stiff skin passes it on below 100 Hz.
    wanted = (0.05 * 0.6) ** 2 / (f * np.sum(1 / np.arange(1.0, WAVES + 1)))
    ratio = found.spectrum.values[band] / wanted[band]
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.15)
    slope = np.polyfit(np.log(f[band]), np.log(found.spectrum.values[band]), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.15)
    grid = np.geomspace(5.0, 100.0, 50)
    assert np.mean(10 * np.log10(found.density(grid) * grid / np.mean(wanted * f))) == pytest.approx(0.0, abs=1.0)


def test_tremor_is_a_peak_where_it_should_be_of_the_right_size() -> None:
    found = identify_noise(TREMBLES, seeds=range(6))
    f, density = found.spectrum["frequency"].values, found.spectrum.values
    assert 8.0 <= f[np.argmax(density)] <= 12.0
    assert 8.0 <= (grid := np.geomspace(1, 100, 2000))[np.argmax(found.density(grid))] <= 12.0
    # f0 (N/N0)^n: a force of 30 mN on 0.5 N, to first order.
    band = np.geomspace(3.0, 40.0, 2000)
    rms_n = np.sqrt(np.trapezoid(found.density(band), band))
    assert rms_n == pytest.approx(0.9 * 0.6 / 0.5 * 0.03, rel=0.15)


@settings(max_examples=15)
@given(
    level=st.floats(-8, -2),
    corner=st.floats(3, 60),
    centre=st.floats(7, 14),
    width=st.floats(2, 5),
    ratio=st.floats(1, 30),
)
def test_fit_finds_a_filter_of_its_own_kind(level, corner, centre, width, ratio) -> None:
    f = np.arange(1.0, 400.0, 0.5)
    background = 10**level / (1 + (f / corner) ** 2)
    peak = ratio * 10**level * centre**2 * width**2 / ((centre**2 - f**2) ** 2 + (width * f) ** 2)
    A, B, C, D = filter_ = fit_shaping(f, background + peak)
    assert np.all(np.linalg.eigvals(A).real < 0) and np.all(np.linalg.eigvals(A - B @ C / D).real < 0)
    below = f <= 200
    error = 10 * np.log10(np.abs(filter_.at(2j * np.pi * f[below])[:, 0, 0]) ** 2 / (background + peak)[below])
    assert np.sqrt(np.mean(error**2)) < 1.5
