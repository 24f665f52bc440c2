"""The weighting filter: its gain, its roots, its fit, its compiled step against scipy, its start."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.interpolate import interp1d
from scipy.optimize import minimize_scalar
from scipy.signal import freqs_zpk, sos2zpk, sosfilt, sosfilt_zi, sosfreqz
from streaming import settled_state, weighting_error_db
from weighting_fit import fit_prototype

from frictionloop.parameters import Skin
from frictionloop.perception import displacement_threshold_um, force_threshold_n, weighting_sos
from frictionloop.perception.detection_thresholds import THRESHOLD_UM
from frictionloop.perception.weighting import ERROR_DB, GRID_HZ, HIGHPASS_HZ, PROTOTYPE, RATES_HZ, gain_db, roots_of
from frictionloop.quantities import FrictionloopError, Lti
from frictionloop.quantities.scalar_math import biquad_step

RATES = [1200.0, 2000.0, 5000.0, 10_000.0, 50_000.0, 200_000.0]
rates = st.floats(math.log(RATES_HZ[0]), math.log(RATES_HZ[1])).map(lambda x: min(math.exp(x), RATES_HZ[1]))
fingers = st.builds(
    Skin, stiffness_n_m=st.floats(100, 1e4), damping_n_s_m=st.floats(0.1, 10), mass_kg=st.floats(1e-6, 1e-3)
)


@njit
def filtered(x, sections, states):
    """The cascade as a loop writes it: one scalar step per section and sample."""
    out = np.empty_like(x)
    for i in range(x.size):
        y = x[i]
        for j in range(len(sections)):
            b0, b1, b2, _, a1, a2 = sections[j]
            states[j, 0], states[j, 1], y = biquad_step(states[j, 0], states[j, 1], y, b0, b1, b2, a1, a2)
        out[i] = y
    return out


def power(values):
    return np.mean(np.square(values))


def test_the_stored_prototype_is_what_the_fit_finds():
    found = fit_prototype()
    np.testing.assert_allclose(PROTOTYPE.gain_per_um, found.gain_per_um, rtol=1e-4)
    np.testing.assert_allclose(PROTOTYPE.zeros, found.zeros, rtol=1e-4)
    np.testing.assert_allclose(PROTOTYPE.poles, found.poles, rtol=1e-4)


def test_the_prototype_is_within_half_a_decibel_of_the_table():
    error = gain_db(PROTOTYPE, GRID_HZ) + 20 * np.log10(displacement_threshold_um(GRID_HZ))
    assert np.abs(error).max() <= 0.44
    assert math.sqrt(power(error)) <= 0.12


def test_the_gain_of_the_prototype_is_that_of_its_roots():
    pairs = [(HIGHPASS_HZ, math.sqrt(0.5)), *PROTOTYPE.poles]
    zeros = np.concatenate([[0, 0], *(roots_of(*pair) for pair in PROTOTYPE.zeros)])
    poles = np.concatenate([roots_of(*pair) for pair in pairs])
    gain = PROTOTYPE.gain_per_um
    for corners, sign in ((PROTOTYPE.zeros, -1), (PROTOTYPE.poles, 1)):
        gain *= math.prod((2 * math.pi * corner) ** (2 * sign) for corner, _ in corners)
    _, response = freqs_zpk(zeros, poles, gain, 2 * np.pi * GRID_HZ)
    np.testing.assert_allclose(gain_db(PROTOTYPE, GRID_HZ), 20 * np.log10(np.abs(response)), atol=1e-9)


@given(st.floats(0.1, 1e3), st.floats(0.01, 100))
def test_roots_solve_their_polynomial(corner, damping):
    omega = 2 * math.pi * corner
    roots = roots_of(corner, damping)
    assert np.all(roots.real < 0)
    np.testing.assert_allclose(np.prod(roots), omega**2, rtol=1e-12)
    np.testing.assert_allclose(np.sum(roots), -2 * damping * omega, rtol=1e-12)


@pytest.mark.parametrize("rate", RATES)
def test_the_gain_is_one_over_the_threshold(rate):
    error = weighting_error_db(rate)
    # Asked: 0.5 dB rms and 1.5 dB at most.
    assert math.sqrt(power(error)) <= 0.12
    assert np.abs(error).max() <= ERROR_DB
    frequency = np.array([1.0, 17.0, 240.0, 500.0])
    _, response = sosfreqz(weighting_sos(rate), frequency, fs=rate)
    wanted = 20 * np.log10(np.abs(response) * force_threshold_n(frequency))
    np.testing.assert_allclose(weighting_error_db(rate, frequency_hz=frequency), wanted, atol=1e-9)


@given(rates, fingers)
@settings(max_examples=50, deadline=None)
def test_any_finger_at_any_rate_is_stable_of_minimum_phase_and_within_the_error(rate, finger):
    sos = weighting_sos(rate, finger)
    assert sos.shape == (5, 6)
    assert np.all(sos[:, 3] == 1.0)
    np.testing.assert_array_equal(sos[0, :3], [1.0, -2.0, 1.0])  # blocks a constant exactly
    zeros, poles, gain = sos2zpk(sos[1:])
    assert np.all(np.abs(poles) < 1)
    assert np.all(np.abs(zeros) < 1)
    assert np.all(np.abs(sos2zpk(sos[:1])[1]) < 1)
    assert gain > 0
    assert np.abs(weighting_error_db(rate, finger)).max() <= ERROR_DB


@given(fingers, fingers)
@settings(max_examples=30, deadline=None)
def test_two_fingers_differ_by_their_skin_alone(one, other):
    between = weighting_error_db(5000.0, one) - weighting_error_db(5000.0, other)
    np.testing.assert_allclose(between, 0.0, atol=0.01)  # dB: what the two free zeros leave of the sampling


@pytest.mark.parametrize("rate", [2000.0, 5000.0, 50_000.0])
def test_outside_the_band_the_gain_falls(rate):
    below, above = np.array([1.0, 0.5, 0.1, 0.01, 0.0]), np.array([500.0, 600.0, 700.0, 800.0, 990.0])
    for frequencies in (below, above):
        gain = np.abs(sosfreqz(weighting_sos(rate), frequencies, fs=rate)[1])
        assert np.all(np.diff(gain) < 0)
    assert gain[-1] < 0.2 * gain[0]  # an octave above: -14 dB or more
    very_low = np.abs(sosfreqz(weighting_sos(rate), [0.1, 0.01], fs=rate)[1])
    assert very_low[0] / very_low[1] == pytest.approx(100.0, rel=1e-2)  # second order: 40 dB per decade


def test_the_compiled_step_is_scipys_filter():
    sos = weighting_sos(5000.0)
    x = np.random.default_rng(3).normal(size=20_000)
    zi = np.random.default_rng(4).normal(size=(5, 2))
    wanted, _ = sosfilt(sos, x, zi=zi)
    # A fused multiply-add rounds once where scipy rounds twice; poles near 1 keep such differences: eps / (1 - |p|)^2.
    tolerance = 2.0**-52 / 4e-7 * np.abs(wanted).max()
    np.testing.assert_allclose(filtered(x, sos, zi.copy()), wanted, rtol=0, atol=tolerance)


@given(st.lists(st.floats(-1, 1), min_size=5, max_size=5), st.lists(st.floats(-1, 1), min_size=1, max_size=30))
@settings(deadline=None)
def test_one_section_in_closed_form(coefficients, x):
    """The difference equation y[n] = sum b x - sum a y, in exact terms of the past samples."""
    b0, b1, b2, a1, a2 = coefficients[0], coefficients[1], coefficients[2], coefficients[3], coefficients[4] / 2
    s1 = s2 = 0.0
    xs, ys = [0.0, 0.0], [0.0, 0.0]
    for sample in x:
        s1, s2, y = biquad_step(s1, s2, sample, b0, b1, b2, a1, a2)
        direct = b0 * sample + b1 * xs[-1] + b2 * xs[-2] - a1 * ys[-1] - a2 * ys[-2]
        # Each of the five products and sums is rounded at the size of the terms.
        size = abs(sample) + abs(xs[-1]) + abs(xs[-2]) + abs(ys[-1]) + abs(ys[-2])
        assert y == pytest.approx(direct, abs=10 * 2.0**-52 * size + 1e-300)
        xs.append(sample)
        ys.append(y)


@pytest.mark.parametrize("rate", RATES)
def test_a_settled_filter_gives_nothing_for_a_constant(rate):
    sos = weighting_sos(rate)
    np.testing.assert_allclose(settled_state(sos, 1.0)[0], sosfilt_zi(sos[:1])[0], rtol=1e-6)
    y, after = sosfilt(sos, np.full(1000, 0.37), zi=settled_state(sos, 0.37))
    np.testing.assert_array_equal(y, 0.0)
    np.testing.assert_array_equal(after, settled_state(sos, 0.37))
    np.testing.assert_array_equal(filtered(np.full(1000, 0.37), sos, settled_state(sos, 0.37)), 0.0)


def test_a_step_has_decayed_after_the_settling_time():
    high_pass = sosfilt(weighting_sos(5000.0)[:1], np.ones(30_000))
    assert np.abs(high_pass[round(2.0 * 5000) :]).max() < 1 / 400


def test_same_arguments_same_filter_which_a_caller_may_change():
    first = weighting_sos(5000.0)
    again = weighting_sos(5000, Skin())
    np.testing.assert_array_equal(first, again)
    again[:] = 0.0
    np.testing.assert_array_equal(first, weighting_sos(5000.0))


def test_a_finger_that_rings_above_half_the_rate_is_refused():
    """664 Hz and hardly damped: at 1250 Hz there is no pole for it, at 5 kHz there is."""
    finger = Skin(stiffness_n_m=2.9e7, damping_n_s_m=540.0, mass_kg=1.66)
    with pytest.raises(FrictionloopError, match=r"^rate_hz = 1250 Hz: too low to weigh"):
        weighting_sos(1250.0, finger)
    assert np.abs(weighting_error_db(5000.0, finger)).max() <= ERROR_DB


frequency = st.floats(1, 500)
finger = st.builds(
    Skin, stiffness_n_m=st.floats(100, 1e4), damping_n_s_m=st.floats(0.1, 10), mass_kg=st.floats(1e-6, 1e-3)
)

# Forces worked out by hand, in mN to two digits.
PRINTED_MN = {
    **{1: 25, 5: 16, 10: 10, 20: 6.0, 40: 2.6, 60: 1.3, 80: 0.77, 100: 0.46, 150: 0.24},
    **{200: 0.18, 250: 0.17, 300: 0.22, 400: 0.46, 500: 0.94},
}


def test_the_table_of_g2():
    frequencies = [1, 3, 5, 10, 20, 30, 40, 60, 80, 100, 150, 200, 250, 300, 400, 500]
    printed = [25, 20, 16, 10, 6, 4, 2.5, 1.2, 0.7, 0.4, 0.18, 0.12, 0.10, 0.11, 0.18, 0.30]
    np.testing.assert_allclose(displacement_threshold_um(frequencies), printed, rtol=1e-14)


@given(frequency)
def test_straight_lines_in_log_log(f):
    line = interp1d(np.log10(list(THRESHOLD_UM)), np.log10(list(THRESHOLD_UM.values())))
    assert displacement_threshold_um(f) == pytest.approx(10 ** line(math.log10(f)), rel=1e-12)


def test_halfway_between_two_points_is_their_geometric_mean():
    assert displacement_threshold_um(math.sqrt(10 * 20)) == pytest.approx(math.sqrt(10 * 6), rel=1e-13)


@given(frequency, finger)
def test_the_force_is_that_of_the_skin_moved_by_the_threshold(f, tip):
    skin = Lti((tip.mass_kg, tip.damping_n_s_m, tip.stiffness_n_m), (1.0,))
    assert force_threshold_n(f, tip) == pytest.approx(
        1e-6 * displacement_threshold_um(f) * abs(skin.response(f)), rel=1e-12
    )


@pytest.mark.parametrize(("frequency_hz", "printed_mn"), PRINTED_MN.items())
def test_printed_forces(frequency_hz, printed_mn):
    got = 1e3 * float(force_threshold_n(frequency_hz))
    assert float(f"{got:.2g}") == printed_mn


def test_the_least_force_is_within_a_factor_of_three_of_the_papers():
    least = minimize_scalar(lambda f: float(force_threshold_n(f)), bounds=(150, 400), method="bounded")
    assert 200 < least.x < 300
    assert 5e-4 / 3 < least.fun < 5e-4 * 3


@given(frequency, finger)
def test_a_stiff_finger_needs_more_force_below_its_resonance(f, tip):
    stiffer = tip.model_copy(update={"stiffness_n_m": 2 * tip.stiffness_n_m})
    if (2 * math.pi * f) ** 2 * tip.mass_kg < tip.stiffness_n_m:
        assert force_threshold_n(f, stiffer) > force_threshold_n(f, tip)
