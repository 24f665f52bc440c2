"""The index D of spectra and residuals, and as it is accumulated: lines, bands, scaling, and what is refused."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from perception_index import index_of_residual, index_of_spectrum
from scipy.integrate import quad
from streaming import streaming_index, weighted_residual, weighting_error_db

from frictionloop.parameters import Skin
from frictionloop.perception import force_threshold_n
from frictionloop.perception.detection_thresholds import THRESHOLD_UM

RATE = 5000.0
GRID = np.linspace(0, 2500, 10001)
FLAT = np.ones_like(GRID)


def times(duration_s):
    return np.arange(round(duration_s * RATE)) / RATE


def exact(density, low, high):
    """The integral of S / F_th^2, by adaptive quadrature between the kinks of the table."""
    edges = [low, *(f for f in THRESHOLD_UM if low < f < high), high]

    def integrand(f):
        return density(f) / float(force_threshold_n(f)) ** 2

    return math.sqrt(sum(quad(integrand, a, b, epsrel=1e-10)[0] for a, b in pairwise(edges)))


@pytest.mark.parametrize(("low", "high"), [(1.0, 500.0), (40.0, 500.0), (1.0, 40.0), (7.3, 8.1), (499.0, 500.0)])
@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_power_laws_against_quadrature(low, high, exponent):
    density = np.maximum(GRID, 0.25) ** -exponent
    grid = np.union1d(GRID, np.geomspace(0.5, 500, 5000))
    fine = np.maximum(grid, 0.25) ** -exponent
    wanted = exact(lambda f: f**-exponent, low, high)
    assert index_of_spectrum(grid, fine, band_hz=(low, high)) == pytest.approx(wanted, rel=1e-5)
    # S is linear between frequencies: at 1 Hz the chord of 1/f^2 over h = 0.25 Hz is up to 6 h^2 / 8 = 4.7 % above it,
    # 3.1 % on average, half of that in D.
    assert index_of_spectrum(GRID, density, band_hz=(low, high)) == pytest.approx(wanted, rel=0.016)


def test_thresholds_are_followed_between_the_frequencies_given():
    assert index_of_spectrum([1.0, 500.0], [1.0, 1.0]) == pytest.approx(exact(lambda f: 1.0, 1.0, 500.0), rel=1e-5)


@given(st.floats(1, 499), st.floats(1e-3, 1e3))
def test_index_grows_with_the_force_and_energies_add(split, gain):
    whole = index_of_spectrum(GRID, FLAT)
    assert index_of_spectrum(GRID, gain**2 * FLAT) == pytest.approx(gain * whole, rel=1e-12)
    if 1.01 < split < 495:
        parts = [index_of_spectrum(GRID, FLAT, band_hz=band) for band in ((1.0, split), (split, 500.0))]
        assert math.hypot(*parts) == pytest.approx(whole, rel=2e-5)


@pytest.mark.parametrize("frequency_hz", [3.0, 10.0, 33.3, 100.0, 250.0, 400.0])
@pytest.mark.parametrize("phase", [0.0, 1.0])
def test_a_sine_is_its_rms_over_the_threshold(frequency_hz, phase):
    sine = 0.01 * np.sin(2 * np.pi * frequency_hz * times(20) + phase)
    wanted = 0.01 / math.sqrt(2) / float(force_threshold_n(frequency_hz))
    # The window spreads the line over +-0.5 Hz, and F_th bends over that width: 1.2 % at 3 Hz, where it is widest.
    assert index_of_residual(sine, RATE) == pytest.approx(wanted, rel=0.012)


def test_a_sine_at_its_threshold_has_minus_3_db():
    sine = float(force_threshold_n(200.0)) * np.sin(2 * np.pi * 200.0 * times(8))
    assert 20 * np.log10(index_of_residual(sine, RATE)) == pytest.approx(-10 * math.log10(2), abs=0.01)


@given(st.floats(-10, 10), st.floats(-0.1, 0.1))
@settings(max_examples=20)
def test_mean_and_straight_drift_do_not_count(mean, slope):
    t = times(8)
    ripple = 1e-3 * np.sin(2 * np.pi * 60 * t)
    alone, drifting = index_of_residual([ripple, ripple + mean + slope * t], RATE)
    assert drifting == pytest.approx(alone, rel=1e-9)


def test_lanes_are_independent_and_nothing_is_nothing():
    noise = np.random.default_rng(0).normal(size=(2, 3, 20000))
    together = index_of_residual(noise, RATE)
    assert together.shape == (2, 3)
    assert together[1, 2] == pytest.approx(float(index_of_residual(noise[1, 2], RATE)), rel=1e-12)
    assert index_of_residual(np.zeros(20000), RATE) == 0.0


@pytest.mark.parametrize("samples", [5000, 5001, 20001])
def test_any_length_from_one_second_on(samples):
    assert index_of_residual(np.random.default_rng(0).normal(size=samples), RATE) > 0


@pytest.mark.parametrize("samples", [4001, 4002])
def test_a_rate_of_twice_the_upper_limit_is_enough(samples):
    noise = np.random.default_rng(0).normal(size=samples)
    assert index_of_residual(noise, 1000.0) > 0
    assert index_of_residual(noise, 400.0, band_hz=(1.0, 200.0)) > 0


def test_a_stiffer_finger_feels_less():
    assert index_of_spectrum(GRID, FLAT, Skin(stiffness_n_m=2000.0)) < index_of_spectrum(GRID, FLAT)


def sine(frequency_hz, duration_s, amplitude_n=0.01):
    return amplitude_n * np.sin(2 * np.pi * frequency_hz * np.arange(round(duration_s * RATE)) / RATE)


@pytest.mark.parametrize("frequency_hz", [1.0, 2.0, 10.0, 40.0, 100.0, 250.0, 400.0, 500.0])
def test_a_sine_is_its_rms_over_the_threshold_times_the_error_of_the_fit(frequency_hz):
    exact = 0.01 / math.sqrt(2) / float(force_threshold_n(frequency_hz))
    fit = 10 ** (float(weighting_error_db(RATE, frequency_hz=frequency_hz)) / 20)
    # Whole periods; after 5 s the start has decayed to e^-15.
    assert streaming_index(sine(frequency_hz, 10), RATE, skip_s=5.0) == pytest.approx(exact * fit, rel=1e-5)


def test_a_mean_does_not_enter_and_does_not_as_a_start():
    ripple = sine(60.0, 4)
    assert streaming_index(ripple + 2.0, RATE) == pytest.approx(float(streaming_index(ripple, RATE)), rel=1e-9)
    np.testing.assert_array_equal(weighted_residual(np.full(100, 0.4), RATE), 0.0)
