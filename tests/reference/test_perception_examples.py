"""Examples worked by hand before the code was written, and the streaming index against the spectral one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from perception_index import index_of_residual, index_of_spectrum
from scipy.signal import sosfreqz
from streaming import streaming_index

from frictionloop.perception import force_threshold_n, weighting_sos
from frictionloop.perception.weighting import ERROR_DB

RATE = 5000.0
GRID = np.union1d(np.linspace(0, 2500, 20_001), np.geomspace(0.01, 2499, 4000))


def flat(rms_n, low_hz, high_hz):
    """D of a flat density between two frequencies, integrated over that band alone, so that its edges are sharp."""
    density = np.full_like(GRID, rms_n**2 / (high_hz - low_hz))
    return float(index_of_spectrum(GRID, density, band_hz=(low_hz, high_hz)))


def test_the_noise_floor_of_the_sensor_is_not_felt():
    """5e-5 N rms, white over the 471 Hz equivalent bandwidth of a 300 Hz pole: printed D 0.18, -15 dB."""
    index = float(index_of_spectrum(GRID, np.full_like(GRID, 5e-5**2 / 471)))
    assert float(f"{index:.2f}") == 0.18
    assert round(20 * math.log10(index)) == -15
    assert index < 10 ** (-6 / 20)  # not felt with thresholds 6 dB lower either


def test_the_same_number_as_a_density_is_felt():
    """5e-5 N/rtHz: printed D 3.9, +12 dB."""
    index = flat(5e-5 * math.sqrt(499), 1.0, 500.0)
    assert float(f"{index:.1f}") == 3.9
    assert round(20 * math.log10(index)) == 12
    assert index > 10 ** (6 / 20)  # felt with thresholds 6 dB higher, too


def test_tremor_is_barely_felt():
    """20 mN rms at 8 to 12 Hz: printed D 2.0."""
    assert float(f"{flat(0.020, 8.0, 12.0):.1f}") == 2.0


def test_slow_variation_at_the_threshold():
    """Flat from 1 to 20 Hz: D = 1 at 9.3 mN rms printed, 9.1 mN by the formula and table (0.15 dB apart)."""
    rms_mn = 1e3 / flat(1.0, 1.0, 20.0)
    # Independent: the mean of 1/F_th^2 by the midpoint rule.
    middle = 1 + 19 * (np.arange(100_000) + 0.5) / 100_000
    assert rms_mn == pytest.approx(1e3 / math.sqrt(np.mean(force_threshold_n(middle) ** -2)), rel=1e-5)
    assert float(f"{rms_mn:.1f}") == 9.1


def test_friction_noise_is_felt_by_what_it_has_above_40_hz():
    """20 mN rms, 1/f in power from 1 to 100 Hz: printed D 10, nearly all from above 40 Hz."""
    density = 0.020**2 / math.log(100) / np.maximum(GRID, 0.5)
    index, fast = (float(index_of_spectrum(GRID, density, band_hz=(low, 100.0))) for low in (1.0, 40.0))
    assert round(index) == 10
    assert fast**2 / index**2 > 0.9


def streamed(density, low_hz=0.0, high_hz=RATE / 2):
    """D of the filter for a density: sqrt(integral of S |H|^2 df), the rms of its output."""
    inside = (low_hz <= GRID) & (high_hz >= GRID)
    gain = np.abs(sosfreqz(weighting_sos(RATE), GRID[inside], fs=RATE)[1])
    return math.sqrt(np.trapezoid((density * np.ones_like(GRID))[inside] * gain**2, GRID[inside]))


@given(st.floats(-1, 3), st.floats(1, 400), st.floats(0.05, 2))
@settings(max_examples=40, deadline=None)
def test_any_spectrum_within_the_band_agrees_to_the_error_of_the_fit(exponent, centre, width):
    density = np.maximum(GRID, 0.01) ** -exponent * np.exp(-((np.log(np.maximum(GRID, 0.01) / centre) / width) ** 2))
    error_db = 20 * math.log10(streamed(density, 1.0, 500.0) / index_of_spectrum(GRID, density))
    assert abs(error_db) <= ERROR_DB


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
def test_spectra_that_reach_beyond_the_band_add_little(exponent):
    """White noise to half the rate, and 1/f^n down to 0.2 Hz: what the filter lets through from outside is counted."""
    density = np.maximum(GRID, 0.2) ** -exponent
    ratio = streamed(density) / float(index_of_spectrum(GRID, density))
    assert abs(20 * math.log10(ratio)) <= ERROR_DB
    outside = 1 - (streamed(density, 1.0, 500.0) / streamed(density)) ** 2
    assert 0 < outside < 0.02  # of the energy


def coloured(exponent, seconds, seed):
    """Noise with S ~ 1/f^n by shaping a random spectrum, from 0.2 Hz on; 20 mN rms."""
    rng = np.random.default_rng(seed)
    samples = round(seconds * RATE)
    frequency = np.fft.rfftfreq(samples, 1 / RATE)
    shape = np.where(frequency >= 0.2, np.maximum(frequency, 0.2) ** (-exponent / 2), 0.0)
    noise = np.fft.irfft(shape * (rng.normal(size=frequency.size) + 1j * rng.normal(size=frequency.size)), samples)
    return 0.020 * noise / noise.std()


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("mean", [0.0, 0.3])
def test_noises_agree_in_time(exponent, mean):
    """Both see the same 60 s of noise, so what differs is the fit, and little else: windows, edges of the band."""
    residual = coloured(exponent, 60.0, seed=1) + mean
    ratio = streaming_index(residual, RATE, skip_s=2.0) / index_of_residual(residual, RATE)
    assert abs(20 * math.log10(ratio)) <= ERROR_DB


@pytest.mark.parametrize("frequency_hz", [2.0, 10.0, 40.0, 100.0, 250.0, 400.0])
def test_sines_agree_in_time(frequency_hz):
    residual = 0.01 * np.sin(2 * np.pi * frequency_hz * np.arange(round(20 * RATE)) / RATE)
    ratio = streaming_index(residual, RATE, skip_s=5.0) / index_of_residual(residual, RATE)
    assert abs(20 * math.log10(ratio)) <= ERROR_DB
