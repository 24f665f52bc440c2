"""Simulated calibration rigs: mechanics in closed form and by solvers, noise by its covariance, and bad input."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import xarray as xr
from floor_terms import floor_terms
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import frictionloop as fl
from frictionloop.identification import rigs
from frictionloop.identification.rigs import sensor_rig
from frictionloop.identification.rigs import sensor_rig as rig_hammer
from frictionloop.identification.rigs.weights import _tension
from frictionloop.parameters.calibration_bench import CalibrationBench, Pulley
from frictionloop.sensing.force_sensor import (
    SuspensionState,
    convert_step,
    converter,
    linearise_sensor,
    suspension_coefficients,
    suspension_step,
)

BENCH = CalibrationBench()
PERFECT = BENCH.evolve(
    {
        "errors.gain_error": 0.0,
        "errors.offset_n": 0.0,
        "errors.nonlinearity": 0.0,
        "sensor.noise_density_n_rthz": 0.0,
        "sensor.adc_bits": 32,
        "base.vibration_ug": 0.0,
        "weights.tolerance": 0.0,
        "weights.swing_deg": 0.0,
        "pulley.bearing_friction": 0.0,
        "pulley.drag_n": 0.0,
        "hammer.gain_error": 0.0,
        "hammer.noise_n": 0.0,
    }
)


def complaint(function, *arguments, **named):
    with pytest.raises(fl.FrictionloopError) as failure:
        function(*arguments, **named)
    assert "\n" not in str(failure.value)
    return str(failure.value)


# The sensor


@pytest.mark.parametrize("rate_hz", [600.0, 5000.0, 50000.0])
def test_the_step_is_that_of_the_loop(rate_hz):
    equations = sensor_rig.rates(BENCH)
    step = expm(equations.drift / rate_hz)
    c = suspension_coefficients(BENCH.sensor, 1 / rate_hz)
    np.testing.assert_allclose(step[0, :2], [c.a11, c.a12], atol=1e-14)
    np.testing.assert_allclose(step[1, :2], [c.a21, c.a22], atol=1e-14)
    np.testing.assert_allclose(step[2, :3], [c.a31, c.a32, c.a33], atol=1e-14)


def test_held_forces_give_what_the_steps_of_the_loop_give():
    rng = np.random.default_rng(1)
    force = rng.normal(size=400)
    c = suspension_coefficients(BENCH.sensor, 1 / 5000)
    state, expected = SuspensionState(force[0], 0.0, force[0]), []
    for f in force:
        expected.append(state.filtered_n)
        state = suspension_step(state, f, c)
    np.testing.assert_allclose(sensor_rig.held_response(BENCH, force, 5000.0), expected, rtol=0, atol=1e-11)


def test_the_converter_is_that_of_the_loop():
    bench = PERFECT.evolve({"sensor.adc_bits": 8})
    forces = np.linspace(-3, 3, 1001)
    expected = [convert_step(f, converter(bench.sensor)) for f in forces]
    np.testing.assert_array_equal(sensor_rig.reading(bench, forces), expected)


def test_gain_offset_and_curvature():
    bench = PERFECT.evolve({"errors.gain_error": 0.1, "errors.offset_n": 0.2, "errors.nonlinearity": 0.01})
    forces = np.array([-1.25, 0.0, 1.25])
    expected = 0.2 + 1.1 * forces * (1 + 0.01 / 4)
    np.testing.assert_allclose(sensor_rig.reading(bench, forces), expected, atol=2.5 * 2.0**-31)


@pytest.mark.parametrize("cutoff_hz", [300.0, 1000.0])
def test_noise_terms_against_integrals_of_the_spectrum(cutoff_hz):
    bench = BENCH.evolve({"sensor.cutoff_hz": cutoff_hz, "base.vibration_ug": 30.0, "base.corner_hz": 70.0})
    terms = floor_terms(bench)
    assert terms.electronics_n == pytest.approx(bench.sensor.noise_rms_n, rel=1e-9)
    shaking_n = 0.4 * 30e-6 * 9.80665
    density = shaking_n / math.sqrt(math.pi / 2 * 70.0)
    springs, pole = linearise_sensor(bench.sensor)
    response = (springs * pole).response

    def power(f):
        return (density * abs(response(f))) ** 2 / (1 + (f / 70.0) ** 2)

    pieces = [0, 50, 130, 140, 145, 150, 160, 250, 1000, 1e5]
    total = sum(quad(power, a, b, epsabs=0, epsrel=1e-10)[0] for a, b in itertools.pairwise(pieces))
    assert terms.base_n == pytest.approx(math.sqrt(total), rel=1e-7)
    assert terms.converter_n == pytest.approx(5 / 65536 / math.sqrt(12))
    assert terms.rms_n == pytest.approx(math.sqrt(sum(t**2 for t in terms)))


@pytest.mark.parametrize("rate_hz", [700.0, 5000.0, 40000.0])
def test_noise_has_the_covariance_of_its_equations(rate_hz):
    """Lag 0 and lag 1 of many short records; every record starts stationary, so the first sample counts, too."""
    at_rest = sensor_rig.covariance(BENCH)
    step = expm(sensor_rig.rates(BENCH).drift / rate_hz)
    records = np.stack([sensor_rig.spring_noise(BENCH, 5, rate_hz, seed) for seed in range(200)])
    variance = at_rest[2, 2]
    # A mean square of n normals is off by sqrt(2/n); five of those errors.
    for k in (0, 4):
        assert np.mean(records[:, k] ** 2) == pytest.approx(variance, rel=5 * math.sqrt(2 / 200))
    lagged = (step @ at_rest)[2, 2]
    spread = math.sqrt((variance**2 + lagged**2) / 200)
    assert np.mean(records[:, 3] * records[:, 4]) == pytest.approx(lagged, abs=5 * spread)


# Pulley


@given(st.floats(0, 3), st.floats(0.5, 40), st.floats(1, 359))
def test_a_turning_pulley_balances_its_torques(friction, axle_mm, wrap_deg):
    pulley = Pulley(
        bearing_friction=friction, axle_radius_mm=axle_mm, radius_mm=50.0, wrap_deg=wrap_deg, string_friction=1e3
    )
    lever = friction * axle_mm / 50.0
    if lever >= 0.9:
        return

    def torque(exponent):
        ratio, wrap = math.exp(exponent), math.radians(wrap_deg)
        return ratio - 1 - lever * math.sqrt(ratio**2 + 1 - 2 * ratio * math.cos(wrap))

    exact = brentq(torque, 0, 20, xtol=1e-14) if lever > 1e-6 else 2 * math.sin(math.radians(wrap_deg) / 2) * lever
    assert rigs.friction_exponent(pulley) == pytest.approx(exact, rel=1e-6, abs=1e-9)


def test_a_blocked_pulley_lets_the_string_slide():
    for friction in (20.0, 1e6):
        blocked = Pulley(bearing_friction=friction, string_friction=0.2)
        assert rigs.friction_exponent(blocked) == pytest.approx(0.2 * math.pi / 2)


@given(st.floats(1e-6, 1.0))
def test_friction_for_an_exponent(exponent):
    sliding = Pulley(bearing_friction=1e9, string_friction=rigs.string_friction_for(exponent))
    assert rigs.friction_exponent(sliding) == pytest.approx(exponent)
    turning = Pulley(bearing_friction=rigs.bearing_friction_for(exponent, Pulley()), string_friction=1e9)
    assert rigs.friction_exponent(turning) == pytest.approx(exponent)


FORCES = st.lists(st.floats(0, 3), min_size=2, max_size=30)


@given(FORCES)
def test_a_pulley_stays_in_its_band_and_forgets_nothing_between_extremes(forces):
    pulley = Pulley(bearing_friction=2.0, drag_n=0.01)
    b, weight = rigs.friction_exponent(pulley), np.array(forces)
    found = rigs.pulled(weight, pulley)
    assert np.all(found >= np.maximum(weight * math.exp(-b) - 0.01, 0) - 1e-12)
    assert np.all(found <= weight * math.exp(b) + 0.01 + 1e-12)
    # Rate independence: straight lines in between change nothing.
    k = np.arange(weight.size)
    fine = rigs.pulled(np.interp(np.linspace(0, weight.size - 1, 4 * (weight.size - 1) + 1), k, weight), pulley)
    np.testing.assert_allclose(fine[::4], found, atol=1e-12)


def test_a_pulley_without_friction_passes_everything():
    weight = np.random.default_rng(0).uniform(0, 2, 50)
    np.testing.assert_array_equal(rigs.pulled(weight, Pulley(bearing_friction=0.0, drag_n=0.0)), weight)


# Weights


def test_perfect_weights_weigh_what_they_weigh():
    run = rigs.weights_rig([0.0, 0.1, 0.2, 0.05], PERFECT, dwell_s=2.0)
    ends = run["f_m"].values[9999::10000]
    np.testing.assert_allclose(ends, np.array([0.0, 0.1, 0.2, 0.05]) * 9.80665, atol=1e-8)
    np.testing.assert_array_equal(run["mass"].values[::10000], [0.0, 0.1, 0.2, 0.05])


def test_the_swing_changes_the_tension_as_a_pendulum_does():
    bench = PERFECT.evolve({"weights.swing_deg": 3.0, "weights.swing_decay_s": 1e6})
    tension = _tension(np.array([0.1, 0.1]), 20000, 5000.0, bench)[20000:]
    phi0, g, length = math.radians(3.0), 9.80665, 0.2
    times = np.arange(2000, 20000) / 5000.0
    swing = solve_ivp(
        lambda t, y: [y[1], -g / length * math.sin(y[0])], (0, 4), [phi0, 0], t_eval=times, rtol=1e-10, atol=1e-12
    )
    exact = 0.1 * (g * np.cos(swing.y[0]) + length * swing.y[1] ** 2)
    # Left out are terms in phi0^4 and the slower turn of a wide swing, w phi0^2/16: 2 * 7 * 4 s * phi0^2/16 of phase.
    allowed = 0.1 * g * (phi0**4 + 0.75 * phi0**2 * (2 * 7.0 * 4 * phi0**2 / 16))
    np.testing.assert_allclose(tension[2000:], exact, atol=allowed)


def test_a_weight_has_the_same_error_whenever_it_hangs():
    bench = PERFECT.evolve({"weights.tolerance": 0.01})
    ends = rigs.weights_rig([0.0, 0.1, 0.2, 0.1, 0.2], bench, dwell_s=2.0, seed=4)["f_m"].values[9999::10000]
    error = ends[1:] / (np.array([0.1, 0.2, 0.1, 0.2]) * 9.80665) - 1
    assert error[0] == pytest.approx(error[2], abs=1e-8)
    assert error[0] != pytest.approx(error[1], abs=1e-5)
    assert np.all(np.abs(error) <= 0.01)


# Hammer


@settings(max_examples=30)
@given(st.floats(0.51, 60), st.floats(1e-3, 1e-2), st.floats(200, 5000))
def test_response_to_half_a_sine_against_the_matrix_exponential(q, duration_s, cutoff_hz):
    """Springs, pole and an oscillator that makes the sine, as one linear system; after the pulse without it."""
    sensor = BENCH.evolve({"sensor.q": q, "sensor.cutoff_hz": cutoff_hz}).sensor
    w, wc, drive = 2 * math.pi * 145.0, 2 * math.pi * cutoff_hz, math.pi / duration_s
    rows = [[0, w, 0, 0, 0], [-w, -w / q, 0, w, 0], [wc, 0, -wc, 0, 0], [0, 0, 0, 0, drive], [0, 0, 0, -drive, 0]]
    system = np.array(rows, dtype=float)

    def state(time):
        return (expm(system * time) @ [0, 0, 0, 0, 1])[:3]

    after = state(duration_s)
    times = np.concatenate(
        [[-1e-3, 0.0], np.linspace(0.01, 0.99, 12) * duration_s, duration_s + np.geomspace(1e-5, 0.1, 12)]
    )
    exact = [
        0.0 if t <= 0 else state(t)[2] if t < duration_s else (expm(system[:3, :3] * (t - duration_s)) @ after)[2]
        for t in times
    ]
    found = rig_hammer.half_sine_response(sensor, times, duration_s)
    # Just above Q = 0.5 two poles meet and their residues cancel: a hundredth apart costs two digits.
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-11)


def test_the_hammer_of_a_perfect_bench():
    bench = PERFECT.evolve({"hammer.peak_spread": 0.0, "hammer.width_spread": 0.0})
    run = rigs.hammer_rig(bench, hits=3, peak_n=0.7, pulse_s=4e-3, rate_hz=20000.0)
    force = run["hammer"].values
    assert force.max() == pytest.approx(0.7, rel=1e-3)
    # Momentum of half a sine is 2 A T/pi, three times; so is that of the reading, whose gain at 0 Hz is one.
    momentum = 3 * 2 * 0.7 * 4e-3 / math.pi
    assert force.sum() / 20000.0 == pytest.approx(momentum, rel=1e-4)
    assert run["f_m"].values.sum() / 20000.0 == pytest.approx(momentum, rel=1e-3)


# Datasets


@pytest.mark.parametrize("rig", [rigs.weights_rig, rigs.hammer_rig, rigs.floor_rig], ids=lambda rig: rig.__name__)
def test_a_rig_gives_a_recording(rig, tmp_path):
    quick = {"masses_kg": [0, 0.1, 0.05], "dwell_s": 1.5} if rig is rigs.weights_rig else {}
    run = rig(seed=7, **quick)
    assert run["time"].attrs["units"] == "s"
    assert all(run[name].attrs["units"] in ("N", "kg") and run[name].attrs["long_name"] for name in run.data_vars)
    assert run.attrs["source"] == "simulated"
    assert run.attrs["seed"] == 7
    assert CalibrationBench.model_validate_json(run.attrs["bench"]) == BENCH
    fl.save(run, tmp_path / "run.h5")
    xr.testing.assert_identical(fl.load(tmp_path / "run.h5"), run)
    xr.testing.assert_identical(rig(seed=7, **quick), run)
    assert not np.array_equal(rig(seed=8, **quick)["f_m"], run["f_m"])


# Bad input


def test_the_hit_that_is_called_hard_enough_is_accepted():
    said = complaint(rigs.hammer_rig, peak_n=10.0)
    most = float(said.rsplit("at most", 1)[1].split()[0])
    rigs.hammer_rig(peak_n=most)
    complaint(rigs.hammer_rig, peak_n=1.01 * most)


@given(st.floats(0.0, 0.3))
@settings(max_examples=20)
def test_masses_are_accepted_up_to_the_range(mass):
    try:
        run = rigs.weights_rig([0.0, mass, 0.0], dwell_s=1.0, rate_hz=100.0)
    except fl.FrictionloopError as error:
        assert "sensor.range_n" in str(error)
        assert mass > 0.24
    else:
        assert float(run["f_m"].max()) <= 2.5
