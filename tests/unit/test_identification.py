"""Identification on data whose parameters are known exactly, against other implementations, and bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from noise_corner import fit_corner
from scipy.signal import bilinear, freqz, lfilter

import frictionloop as fl
import frictionloop.identification as find
from frictionloop.identification import rigs
from frictionloop.identification.frequency_response import model, sandwich
from frictionloop.identification.weights_calibration import arriving

G = 9.80665


def recording(rate_hz=1000.0, units=None, **columns):
    units = {"mass": "kg", "hammer": "N", "f_m": "N"} | (units or {})
    data = {name: ("time", np.asarray(values), {"units": units[name]}) for name, values in columns.items()}
    size = len(next(iter(columns.values())))
    return xr.Dataset(data, {"time": ("time", np.arange(size) / rate_hz, {"units": "s"})})


def complaint(function, *arguments, **named):
    with pytest.raises(fl.FrictionloopError) as failure:
        function(*arguments, **named)
    assert "\n" not in str(failure.value)
    return str(failure.value)


# Estimates


def test_intervals():
    from scipy.stats import norm

    assert find.Estimate(1.0, 0.1, "N").interval(0.9).high == pytest.approx(1 + 0.1 * norm.ppf(0.95))
    # Student's t for 95 % and two degrees of freedom, from printed tables.
    assert find.Estimate(0.0, 1.0, "N", 2).interval().high == pytest.approx(4.303, abs=5e-4)
    assert "confidence" in complaint(find.Estimate(0.0, 1.0, "N").interval, 1.0)


@pytest.mark.parametrize(
    ("estimate", "text"),
    [
        ((145.0012, 0.0035, "Hz"), "145.0012 +- 0.0069 Hz"),
        ((2.3e-6, 3e-8, "N/rtHz"), "(2.300 +- 0.059)e-6 N/rtHz"),
        ((0.0, 0.0, "N"), "0 N"),
        ((20.0, 10.0, ""), "20 +- 20"),
    ],
)
def test_an_estimate_as_text(estimate, text):
    assert str(find.Estimate(*estimate)) == text


# Calibration


def steps(levels, readings, each=50, **more):
    return recording(mass=np.repeat(levels, each), f_m=np.repeat(readings, each), **more)


@given(st.floats(-5, 5).filter(lambda k: abs(k) > 0.01), st.floats(-3, 3), st.integers(0, 1000))
def test_calibration_is_the_line_of_polyfit(slope, offset, seed):
    rng = np.random.default_rng(seed)
    levels = np.array([0.0, 0.05, 0.1, 0.2, 0.15, 0.02])
    readings = offset + slope * levels * G + 0.01 * rng.normal(size=levels.size)
    found = find.weights(steps(levels, readings), settle_s=0.01)
    (k, c), spread = np.polyfit(levels * G, readings, 1, cov=True)
    assert found.sensitivity.value == pytest.approx(k, rel=1e-9)
    assert found.offset.value == pytest.approx(c, abs=1e-9)
    assert found.sensitivity.standard_error == pytest.approx(math.sqrt(spread[0, 0]), rel=1e-6)
    assert found.offset.standard_error == pytest.approx(math.sqrt(spread[1, 1]), rel=1e-6)
    residual = readings - c - k * levels * G
    assert found.r2 == pytest.approx(1 - np.sum(residual**2) / np.sum((readings - readings.mean()) ** 2), abs=1e-9)
    assert found.residual_rms_n == pytest.approx(math.sqrt(np.sum(residual**2) / 4) / abs(k), rel=1e-6)
    np.testing.assert_allclose(found.force_n(readings), levels * G + residual / k, atol=1e-9)


def test_settling_is_left_out_and_units_are_carried():
    mass = np.repeat([0.0, 0.1, 0.2], 100)
    volts = 2.0 + 3.0 * mass * G
    volts[[0, 100, 109, 200, 209]] += 50.0
    found = find.weights(recording(100.0, {"f_m": "V"}, mass=mass, f_m=volts), settle_s=0.1)
    assert found.sensitivity.unit == "V/N"
    assert found.offset.unit == "V"
    assert found.sensitivity.value == pytest.approx(3.0)
    assert found.offset.value == pytest.approx(2.0)
    assert found.steps.direction.tolist() == [0, 1, 1]
    assert math.isnan(found.hysteresis)


def test_hysteresis_is_the_widest_gap_over_the_span():
    found = find.weights(steps([0, 0.1, 0.2, 0.1, 0], [0.0, 0.9, 2.0, 1.2, 0.1]), settle_s=0.0)
    assert found.hysteresis == pytest.approx(0.3 / 2.0)


def test_errors_of_weights_scatter_the_slope_as_told():
    """The mark is fixed, the mass scatters: mean and scatter of the slope over 5000 sets of weights."""
    rng = np.random.default_rng(3)
    levels, tolerance = np.array([0, 0.05, 0.1, 0.15, 0.2, 0.15, 0.1, 0.05, 0.0]), 0.05
    marks, which = np.unique(levels, return_inverse=True)
    hung = levels * (1 + tolerance * rng.uniform(-1, 1, (5000, marks.size))[:, which])
    slopes = np.polyfit(levels, hung.T, 1)[0]
    told = find.weights(steps(levels, levels), settle_s=0.0, tolerance=tolerance).weights_error
    assert np.mean(slopes) == pytest.approx(1.0, abs=5 * told / math.sqrt(5000))
    # The scatter of 5000 values is known to 1 %.
    assert np.std(slopes) == pytest.approx(told, rel=0.05)


def test_perfect_hysteresis_is_found_exactly():
    levels = np.array([0, 0.05, 0.1, 0.15, 0.2, 0.15, 0.1, 0.05, 0.0])
    way = np.sign(np.diff(levels, prepend=levels[0]))
    for b, d in ((0.13, 0.0), (0.02, 0.01), (0.3, 0.004)):
        readings = 0.3 + 2.0 * arriving(levels * G, way, b, d)
        found = find.pulley_friction(find.weights(steps(levels, readings), settle_s=0.0))
        assert found.exponent.value == pytest.approx(b, abs=1e-6)
        assert found.drag.value == pytest.approx(d, abs=1e-6)
        assert found.sensitivity.value == pytest.approx(2.0, abs=1e-5)


@given(st.floats(0.001, 0.5), st.lists(st.floats(0, 2), min_size=3, max_size=20))
def test_what_arrives_is_what_the_pulley_of_the_rig_passes(b, forces):
    """Two implementations: by direction here, by the band there."""
    from frictionloop.parameters.calibration_bench import Pulley

    force = np.array(forces)
    here = arriving(force, np.sign(np.diff(force, prepend=force[0])), b)
    there = rigs.pulled(force, Pulley(bearing_friction=1e9, string_friction=rigs.string_friction_for(b), drag_n=0.0))
    np.testing.assert_allclose(here, there, atol=1e-12)


def test_r2_over_a_pulley():
    loads = np.linspace(0, 2.5, 2001)
    for b in (0.001, 0.01):
        # Residual b F either way: var = b^2 F^2/3 of a variance F^2/12. The first steps down are within order b of it.
        assert 1 / find.r2_with_friction(loads, b) - 1 == pytest.approx(4 * b * b, rel=8 * b)
    assert find.r2_with_friction(loads, 0.0) == pytest.approx(1.0)
    b = find.exponent_for_r2(0.95, loads)
    assert find.r2_with_friction(loads, b) == pytest.approx(0.95, abs=1e-9)


# Figures of merit


def test_printed_figures():
    # By hand: 22 %, 93.98 dB, 1.1 mN and 2.8 mN.
    assert find.residual_share(0.95) == pytest.approx(0.22, abs=5e-3)
    assert find.residual_share(0.95) * find.uniform_std_n(2.5) == pytest.approx(0.16, abs=5e-3)
    assert find.dynamic_range_db(2.5, 5e-5) == pytest.approx(93.98, abs=5e-3)
    readings = find.floor_readings()
    assert readings["rms"].density_n_rthz == pytest.approx(2.3e-6, abs=5e-8)
    assert readings["density"].rms_n == pytest.approx(1.1e-3, abs=5e-5)
    assert readings["per bin, Hann"].rms_n == pytest.approx(2.8e-3, abs=5e-5)
    assert readings["rms"].range_db == pytest.approx(93.98, abs=5e-3)


# Frequency response


def test_h1_of_a_filter_is_that_filter():
    rate, rng = 4000.0, np.random.default_rng(0)
    b, a = bilinear([1.0], [1 / 600.0**2, 1 / (600.0 * 8), 1.0], rate)
    x = np.zeros(40000)
    for k in range(8):
        x[5000 * k + 1000 + 7 * k : 5000 * k + 1012 + 7 * k] = np.hanning(14)[1:-1] * rng.uniform(0.5, 1)
    found = find.response(recording(rate, hammer=x, f_m=lfilter(b, a, x)), segment_s=1.0)
    assert found.hits == 8
    keep = found.frequency_hz < 400
    exact = freqz(b, a, found.frequency_hz[keep], fs=rate)[1]
    np.testing.assert_allclose(found.response[keep], exact, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found.coherence[keep], 1.0, atol=1e-9)


def test_the_error_of_h1_is_that_of_its_scatter():
    """Relative error from coherence against the scatter over repetitions, in the mean over frequencies and runs."""
    rate, rng = 1000.0, np.random.default_rng(5)
    x = np.zeros(40000)
    x[np.arange(20) * 2000 + 500] = 1.0
    responses, errors = [], []
    for _ in range(40):
        found = find.response(recording(rate, hammer=x, f_m=x + 0.002 * rng.normal(size=x.size)), 1.0)
        responses.append(np.abs(found.response))
        errors.append(found.relative_error)
    scatter = np.sqrt(np.mean(np.var(responses, axis=0)))
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(scatter, rel=0.05)


@settings(max_examples=20)
@given(st.floats(60, 200), st.floats(1, 60), st.floats(0.5, 2), st.floats(1e-5, 4e-4))
def test_an_exact_response_is_fitted_exactly(hertz, q, gain, lag_s):
    frequency = np.arange(1.0, 600.0, 2.0)
    x = np.array([math.log(gain), math.log(hertz), math.log(q), lag_s])
    flat = np.ones_like(frequency)
    response = model(frequency, x)
    # By the textbook.
    s = 2j * np.pi * frequency
    w = 2 * np.pi * hertz
    springs = gain * w**2 / (s**2 + s * w / q + w**2)
    np.testing.assert_allclose(response, springs / (1 + s * lag_s), rtol=1e-9)
    measured = find.FrequencyResponse(frequency, response, flat, 0 * flat, flat, 5, 5000.0, "N/N")
    found = find.fit_resonance(measured, (20.0, 590.0))
    assert found.resonance.value == pytest.approx(hertz, rel=1e-6)
    assert found.q.value == pytest.approx(q, rel=1e-5)
    assert found.gain.value == pytest.approx(gain, rel=1e-5)
    assert found.lag.value == pytest.approx(lag_s, abs=1e-8)
    assert found.misfit < 1e-6


def test_the_sandwich_is_least_squares_for_equal_residuals():
    """With many equal variances HC3 agrees with s^2 (J^T J)^-1."""
    rng = np.random.default_rng(2)
    jacobian = np.column_stack([np.ones(20000), rng.normal(size=20000)])
    residuals = rng.normal(size=20000)
    plain = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    np.testing.assert_allclose(sandwich(jacobian, residuals).standard, plain, rtol=0.05)


# Noise


def white(seed, samples=50000, rms=1e-4, rate=5000.0):
    return recording(rate, f_m=rms * np.random.default_rng(seed).normal(size=samples))


def test_density_of_white_noise_and_its_error():
    """Density rms/sqrt(rate/2); the told error against the scatter of 200 records."""
    found = [find.floor_density(find.noise_spectrum(white(seed)), 20, 120) for seed in range(200)]
    values = np.array([each.value for each in found])
    told = np.mean([each.standard_error for each in found])
    exact = 1e-4 / math.sqrt(2500)
    assert np.mean(values) == pytest.approx(exact, abs=5 * told / math.sqrt(200))
    # The scatter of 200 values is known to 5 %.
    assert np.std(values) == pytest.approx(told, rel=0.2)
    assert found[0].unit == "N/rtHz"


def test_the_number_of_averages():
    """Scatter of single frequencies over the spectrum of white noise is 1/sqrt(averages)."""
    spectrum = find.noise_spectrum(white(1, samples=500000), segment_s=0.1)
    inner = spectrum.power_density[2:-2]
    scatter = np.std(inner) / np.mean(inner)
    assert scatter * math.sqrt(spectrum.averages) == pytest.approx(1.0, rel=0.15)


def test_power_of_a_sine_is_in_its_band():
    time = np.arange(50000) / 5000
    spectrum = find.noise_spectrum(recording(5000.0, f_m=0.3 * np.sin(2 * np.pi * 80 * time) + 1.0))
    assert find.band_rms(spectrum, 40, 120).value == pytest.approx(0.3 / math.sqrt(2), rel=0.02)
    assert find.band_rms(spectrum, 200, 400).value < 1e-6


def test_a_first_order_low_pass_is_found():
    """An Ornstein-Uhlenbeck noise, sampled exactly, plus white noise: 40 records, told errors against scatter."""
    rate, corner, rms = 5000.0, 300.0, 5e-5
    q = math.exp(-2 * math.pi * corner / rate)
    values, told = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        x = lfilter([math.sqrt(1 - q * q)], [1, -q], rng.normal(size=60000))[10000:]
        noise = rms * x + 1e-5 * rng.normal(size=50000)
        fit = fit_corner(find.noise_spectrum(recording(rate, f_m=noise)), 3, 2500)
        values.append([fit.corner.value, fit.density.value])
        told.append([fit.corner.standard_error, fit.density.standard_error])
    mean, scatter, told = np.mean(values, axis=0), np.std(values, axis=0), np.mean(told, axis=0)
    exact = np.array([corner, rms / math.sqrt(math.pi / 2 * corner)])
    assert np.all(np.abs(mean - exact) < 4 * told / math.sqrt(40))
    # The scatter of 40 values is known to 11 %.
    np.testing.assert_allclose(scatter, told, rtol=0.35)


def test_a_reading_that_never_changes_has_no_noise():
    still = recording(5000.0, f_m=np.zeros(50000))
    spectrum = find.noise_spectrum(still)
    assert find.band_rms(spectrum, 1, 300).value == 0.0
    assert "step" in complaint(fit_corner, spectrum, 3, 2500)


# A recording is a recording

RUNS = {
    "weights": rigs.weights_rig([0, 0.1, 0.2, 0.1, 0, 0.1], dwell_s=2.0, rate_hz=500.0),
    "hammer": rigs.hammer_rig(hits=4),
    "floor": rigs.floor_rig(duration_s=4.0),
}


def analysed(name, run):
    if name == "weights":
        calibration = find.weights(run)
        return calibration.sensitivity, calibration.offset, calibration.r2, find.pulley_friction(calibration)
    if name == "hammer":
        return find.fit_resonance(find.response(run))
    spectrum = find.noise_spectrum(run)
    return find.floor_density(spectrum, 5, 60), find.band_rms(spectrum, 5, 300), fit_corner(spectrum, 500, 2500)


@pytest.mark.parametrize("name", RUNS)
def test_a_saved_and_loaded_run_gives_identical_results(name, tmp_path):
    fl.save(RUNS[name], tmp_path / "run.h5")
    assert analysed(name, fl.load(tmp_path / "run.h5")) == analysed(name, RUNS[name])


@pytest.mark.parametrize("name", RUNS)
def test_a_text_file_gives_identical_results(name, tmp_path):
    run, path = RUNS[name], tmp_path / "lab.csv"
    columns = list(run.data_vars)
    table = np.column_stack([run["time"].values, *(run[c].values for c in columns)])
    np.savetxt(path, table, fmt="%.17g", delimiter=",", header=",".join(["time", *columns]), comments="")
    back = find.load(path, {column: column for column in columns})
    assert back.attrs["source"] == "recorded"
    assert analysed(name, back) == analysed(name, run)


# Bad input

HIT = np.zeros(2000)
HIT[[200, 1200]] = 1.0
