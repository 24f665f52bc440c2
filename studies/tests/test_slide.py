"""Statistics of a slide: closed forms, scipy's periodogram, noise of known spectrum, the bench without its noises."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from scipy.signal import periodogram
from scipy.stats import binom

import frictionloop as fl
from studies import finger_validation, kept
from studies.slide import slide_statistics
from studies.slide_onset import stick_to_slip
from studies.slide_spectrum import power_law, waves_of

RATE = 5000
BAND = (5.0, 100.0)
STORED = kept.RESULTS
OFF = {"controller.kp": 0.0, "controller.ki": 0.0, "controller.model.max_amplitude_um": 1e-3}


def recorded(f, load=0.5, position=0.0, rate=RATE):
    columns = {"f_a": (f, "N"), "load": (load, "N"), "position": (position, "m")}
    data = {name: ("time", np.zeros_like(f) + values, {"units": unit}) for name, (values, unit) in columns.items()}
    return xr.Dataset(data, {"time": ("time", np.arange(f.size) / rate, {"units": "s"})})


def coloured(random, size, p, rate=RATE):
    """Gaussian noise of spectrum f^-p: a piece of a record eight times as long, so that its ends do not meet."""
    f = np.fft.rfftfreq(8 * size, 1 / rate)
    drawn = random.normal(size=(2, f.size))
    spectrum = np.zeros(f.size, dtype=complex)
    spectrum[1:] = (drawn[0] + 1j * drawn[1])[1:] * f[1:] ** (-p / 2)
    noise = np.fft.irfft(spectrum)[:size]
    return (noise - noise.mean()) / noise.std()


def test_level_drift_and_bands_of_waves_on_a_line():
    t = np.arange(2 * RATE) / RATE
    waves = 0.02 * np.cos(2 * np.pi * 10 * t) + 0.006 * np.cos(2 * np.pi * 50 * t) + 0.03 * np.cos(2 * np.pi * 300 * t)
    found = slide_statistics(recorded(0.4 + 0.1 * (t - 1) + waves, 0.8), 0.0, 2.0)
    assert found.friction_n == pytest.approx(0.4, rel=1e-4)  # the samples' middle is half a sample before 1 s
    assert found.coefficient == pytest.approx(0.5, rel=1e-4)
    # A cosine is even about the middle of the window but for one sample in 10,000, so the line is not touched.
    close = {"rel": 2e-3}
    assert found.drift_per_s == pytest.approx(0.1 / 0.4, **close)
    assert found.tremor == pytest.approx(0.02 / np.sqrt(2) / 0.4, **close)
    assert found.fast == pytest.approx(0.006 / np.sqrt(2) / 0.4, **close)
    assert found.broad == pytest.approx(np.hypot(0.02, 0.006) / np.sqrt(2) / 0.4, **close)
    assert found.spread == pytest.approx(np.sqrt((0.02**2 + 0.006**2 + 0.03**2) / 2) / 0.4, **close)
    assert found.load_spread < 1e-12
    assert (found.load_broad, found.load_correlation, found.load_gain) == (0.0, 0.0, 0.0)
    assert found.own_slope == found.slope


@given(st.integers(0, 2**32 - 1), st.integers(100, 5000))
@settings(max_examples=20)
def test_waves_are_the_periodogram_of_scipy(seed, size):
    values = np.random.default_rng(seed).normal(size=size)
    f, density = periodogram(values, RATE, "hann", detrend="linear")
    inner = slice(1, (size - 1) // 2)  # at 0 and half the rate there is one side alone
    np.testing.assert_allclose(np.abs(waves_of(values)[inner]) ** 2, density[inner] * f[1], rtol=1e-9, atol=1e-18)


@given(st.floats(-3, 6), st.floats(1e-9, 1e3))
def test_an_exact_power_law_has_its_exponent(p, size):
    f = np.arange(500) / 1.3
    found, error = power_law("f", f, size * np.maximum(f, 0.1) ** (-p / 2), BAND)
    assert found == pytest.approx(p, abs=1e-9)
    inside = np.log(f[(f >= 5) & (f <= 100)])
    assert error == pytest.approx(np.sqrt(35 / 18 / inside.size) / inside.std(), rel=1e-12)


@given(st.integers(0, 2**32 - 1), st.floats(0, 3))
@settings(max_examples=20)
def test_the_exponent_is_where_the_likelihood_is_largest(seed, p):
    waves, f = waves_of(coloured(np.random.default_rng(seed), 2 * RATE, p)), np.arange(RATE + 1) / 2
    keep = (f >= 5) & (f <= 100)
    density, f_kept = np.abs(waves[keep]) ** 2, f[keep]

    def minus_log_likelihood(q):
        shape = f_kept**-q
        model = shape * np.mean(density / shape)
        return float(np.sum(np.log(model) + density / model))

    best = minimize_scalar(minus_log_likelihood, bounds=(-3, 6), method="bounded", options={"xatol": 1e-7})
    assert power_law("f", f, waves, BAND)[0] == pytest.approx(best.x, abs=1e-5)


@pytest.mark.parametrize("p", [0.0, 1.0, 2.0])
def test_the_interval_holds_the_exponent_of_noise_in_95_of_100(p):
    random, trials = np.random.default_rng(3), 200
    f = np.fft.rfftfreq(6000, 1 / RATE)
    found = np.array([power_law("f", f, waves_of(coloured(random, 6000, p)), BAND) for _ in range(trials)])
    held = int(np.sum(np.abs(found[:, 0] - p) <= 1.96 * found[:, 1]))
    low, high = binom.interval(0.9999, trials, 0.95)
    assert low <= held <= high


@given(st.floats(0.1, 10), st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_what_is_relative_does_not_depend_on_the_level(scale, seed):
    random = np.random.default_rng(seed)
    f, load = (1 + 0.05 * coloured(random, 6000, 1.0) for _ in range(2))
    one = slide_statistics(recorded(f, load), 0.0, 1.2)
    other = slide_statistics(recorded(scale * f, load), 0.0, 1.2)
    assert other.friction_n == pytest.approx(scale * one.friction_n)
    assert other.coefficient == pytest.approx(scale * one.coefficient)
    np.testing.assert_allclose(other[3:], one[3:], rtol=1e-6)


@given(st.floats(0.3, 2.0), st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_friction_that_follows_the_load_gives_its_exponent(exponent, seed):
    load = 0.5 * (1 + 1e-3 * coloured(np.random.default_rng(seed), 6000, 3.0))
    found = slide_statistics(recorded(0.8 * (load / 0.5) ** exponent, load), 0.0, 1.2)
    assert found.load_correlation == pytest.approx(1.0, abs=1e-4)
    assert found.load_gain == pytest.approx(exponent, rel=1e-2)  # to first order in a load that varies by 1e-3


def test_the_spectrum_left_without_the_load_is_the_one_put_in():
    random = np.random.default_rng(5)
    found = []
    for _ in range(30):
        t, phases = np.arange(6000) / RATE, random.uniform(0, 2 * np.pi, 12)
        load = sum(0.1 / f * np.cos(2 * np.pi * f * t + phase) for f, phase in zip(range(5, 17), phases, strict=True))
        own = 0.02 * coloured(random, 6000, 1.0)
        found.append(slide_statistics(recorded(0.4 * (1 + load + own), 0.5 * (1 + load)), 0.0, 1.2))
    mean, error = np.mean([s.own_slope for s in found]), found[0].slope_error / np.sqrt(30)
    assert abs(mean - 1.0) < 4 * error
    assert np.mean([s.slope for s in found]) > 1.0 + 4 * error


@given(st.floats(200, 5000), st.floats(0.1, 1.0), st.floats(1.05, 2.0), st.floats(5.0, 100.0))
@settings(max_examples=50)
def test_a_spring_that_lets_go(stiffness, kinetic, ratio, speed_mm_s):
    """Force k x up to the peak, then a fall at the same stiffness to the kinetic level."""
    t = np.arange(RATE) / RATE
    x = 1e-3 * speed_mm_s * np.maximum(t - 0.05, 0.0)
    top = ratio * kinetic
    f = np.where(stiffness * x <= top, stiffness * x, np.maximum(2 * top - stiffness * x, kinetic))
    up_s, fall_s = top / (stiffness * 1e-3 * speed_mm_s), (top - kinetic) / (stiffness * 1e-3 * speed_mm_s)
    sample = stiffness * 1e-3 * speed_mm_s / RATE  # change of force from one sample to the next
    assume(0.05 + up_s < 0.8 and fall_s < 0.01 and sample < 0.05 * kinetic)
    found = stick_to_slip(recorded(f, position=x), 0.0, 0.05 + up_s + 2 / RATE)
    assert found.kinetic_n == pytest.approx(kinetic, rel=1e-12)
    assert found.peak_n == pytest.approx(top, abs=sample)
    assert found.ratio == pytest.approx(found.peak_n / kinetic)
    assert found.stiffness_n_m == pytest.approx(stiffness, rel=1e-6)
    assert found.travel_m == pytest.approx(0.8 * kinetic / stiffness, abs=2e-3 * speed_mm_s / RATE)
    assert found.rise_s == pytest.approx(found.travel_m / (1e-3 * speed_mm_s))
    assert found.fall_s == pytest.approx(fall_s, abs=3 / RATE)
    assert found.fall_m == pytest.approx(found.fall_s * 1e-3 * speed_mm_s)


def test_friction_without_a_peak_falls_in_no_time():
    t = np.arange(RATE) / RATE
    found = stick_to_slip(recorded(np.minimum(5 * t, 0.3) + 0.1 * t, position=0.02 * t), 0.0, 0.1)
    assert found.ratio < 1
    assert (found.fall_s, found.fall_m) == (0.0, 0.0)


def test_the_bench_without_noise_slides_at_its_limit_and_has_no_peak():
    still = {"friction.roughness_rms": 0.0, "motion.load_drift": 0.0, "motion.tremor_um": 0.0, "motion.tremor_n": 0.0}
    strokes = {"motion.speed_mm_s": 40.0, "motion.stroke_mm": 100.0, "motion.reversal_s": 0.48, "motion.load_n": 0.6}
    system = fl.bench().evolve(OFF | still | strokes | {"friction.nominal_n": 0.3, "friction.speed_slope": -0.1})
    run, law = fl.simulate(system, 1.6), system.friction
    found, onset = slide_statistics(run, 0.26, 1.46), stick_to_slip(run, 0.0, 0.2)
    slow = law.slow_mm_s**2
    steady = 0.3 * (0.6 / 0.5) ** law.load_exponent * ((40**2 + slow) / (20**2 + slow)) ** (-0.05)
    moist = 1 + (law.occlusion_ratio - 1) * -np.expm1(-np.array([0.26, 0.86, 1.46]) / law.occlusion_s)
    assert found.friction_n == pytest.approx(steady * moist[1], rel=1e-3)  # occlusion is nearly a line
    assert found.drift_per_s == pytest.approx((moist[2] - moist[0]) / moist[1] / 1.2, rel=5e-3)
    assert found.load_n == pytest.approx(0.6)
    # Friction falls with speed from v^2 = vs^2 at rest; the kinetic level is already taken while the finger speeds up.
    assert 1.0 < onset.ratio < ((40**2 + slow) / slow) ** 0.05
    assert onset.stiffness_n_m < system.finger.stiffness_n_m


def test_the_command_finds_what_is_kept(tmp_path, monkeypatch):
    """The kept table, which the page tells in words of its own, is what its command finds today."""
    monkeypatch.setattr(kept, "RESULTS", tmp_path)
    finger_validation.main()
    found, told = ((folder / "finger-validation.csv").read_text(encoding="utf-8") for folder in (tmp_path, STORED))
    assert re.findall(r"^[a-z_]+,", found, re.MULTILINE) == re.findall(r"^[a-z_]+,", told, re.MULTILINE)
    found, told = ([float(x) for x in re.findall(r"-?\d+\.\d+", each.split("\n", 1)[1])] for each in (found, told))
    np.testing.assert_allclose(found, told, rtol=0.02, atol=0.002)  # other machines have other last bits
