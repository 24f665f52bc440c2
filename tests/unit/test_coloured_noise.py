"""Coloured noise against its closed forms: spectrum, variance, stationarity, same bits in any chunks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import simpson
from scipy.signal import sosfreqz, welch

from frictionloop.parameters import ColouredNoise
from frictionloop.physics.coloured_noise import colour, shaping_filter, stationary_state

RATE_HZ = 5000.0
EXPONENTS = [0.0, 0.5, 1.0, 1.5, 2.0]


def power(sos, frequency_hz, rate_hz=RATE_HZ):
    return np.abs(sosfreqz(sos, frequency_hz, fs=rate_hz)[1]) ** 2


def slope(frequency_hz, density):
    return np.polyfit(np.log(frequency_hz), np.log(density), 1)[0]


def make(seed, samples, lanes=(), **parameters):
    random = np.random.default_rng(seed)
    sos = shaping_filter(ColouredNoise(**parameters), RATE_HZ)
    start = stationary_state(sos, random.standard_normal((*lanes, 2 * len(sos))))
    return colour(sos, random.standard_normal((*lanes, samples)), start)[0]


@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize(("low_hz", "high_hz"), [(0.5, 500.0), (5.0, 1e4)])
def test_slope_of_the_response_in_the_inner_band(exponent, low_hz, high_hz):
    sos = shaping_filter(ColouredNoise(exponent=exponent, low_hz=low_hz, high_hz=high_hz), RATE_HZ)
    inner = np.geomspace(6 * low_hz, min(high_hz / 6, RATE_HZ / 20), 300)
    assert slope(inner, power(sos, inner)) == pytest.approx(-exponent, abs=0.03)
    local = np.gradient(np.log(power(sos, inner)), np.log(inner))
    pole_above = 2 / (1 + (high_hz / inner) ** 2) if high_hz < RATE_HZ / 2 else 0.0
    assert np.max(np.abs(local + exponent + pole_above)) < 0.06


def test_level_stays_within_the_ripple_given_beside_the_constant():
    sos = shaping_filter(ColouredNoise(exponent=1.0, low_hz=0.5, high_hz=1e4), RATE_HZ)
    inner = np.geomspace(3.0, RATE_HZ / 20, 500)
    assert np.ptp(10 * np.log10(power(sos, inner) * inner)) < 0.06


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_flat_below_low_hz_and_two_more_above_high_hz(exponent):
    sos = shaping_filter(ColouredNoise(exponent=exponent, low_hz=1.0, high_hz=10.0), RATE_HZ)
    below, above = np.geomspace(1e-3, 0.1, 50), np.geomspace(100.0, 300.0, 50)
    assert np.ptp(np.log(power(sos, below))) < 0.03
    assert slope(above, power(sos, above)) == pytest.approx(-exponent - 2, abs=0.05)


def test_half_the_power_is_left_at_high_hz():
    with_pole = shaping_filter(ColouredNoise(exponent=0.0, low_hz=1.0, high_hz=700.0), RATE_HZ)
    assert power(with_pole, [700.0])[0] / power(with_pole, [0.0])[0] == pytest.approx(0.5, rel=1e-9)


def test_exponent_0_without_a_corner_in_reach_is_the_white_noise_itself():
    white = np.random.default_rng(1).standard_normal(1000)
    sos = shaping_filter(ColouredNoise(exponent=0.0, low_hz=1.0, high_hz=2000.0), RATE_HZ)
    assert colour(sos, white, np.zeros((len(sos), 2)))[0] == pytest.approx(white, abs=1e-12)
    assert not stationary_state(sos, np.ones(2 * len(sos))).any()


def test_exponent_2_is_a_first_order_low_pass_well_below_nyquist():
    sos = shaping_filter(ColouredNoise(exponent=2.0, low_hz=2.0, high_hz=1e4), RATE_HZ)
    f = np.geomspace(0.01, RATE_HZ / 100, 50)
    assert power(sos, f) / power(sos, [0.0]) == pytest.approx(1 / (1 + (f / 2.0) ** 2), rel=0.01)


@settings(deadline=None)
@given(
    exponent=st.floats(0, 2),
    low=st.floats(-6, -0.31).map(lambda decade: 10**decade),
    ratio=st.floats(1.01, 1e4),
    rate_hz=st.sampled_from([100.0, 5000.0, 44100.0]),
)
def test_variance_is_one(exponent, low, ratio, rate_hz):
    low_hz = max(low * rate_hz, 1e-6 * rate_hz)
    sos = shaping_filter(ColouredNoise(exponent=exponent, low_hz=low_hz, high_hz=ratio * low_hz), rate_hz)
    log_f = np.linspace(np.log(low_hz * 1e-7), np.log(rate_hz / 2), 4001)
    total = simpson(power(sos, np.exp(log_f), rate_hz) * np.exp(log_f) * 2 / rate_hz, x=log_f)
    assert total == pytest.approx(1.0, abs=1e-5)
    poles = np.concatenate([np.roots(row[3:]) for row in sos])
    assert np.all(np.abs(poles) < 1)


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_spectrum_measured_by_welch(exponent):
    noise = {"exponent": exponent, "low_hz": 2.0, "high_hz": 1000.0}
    samples = make(3, 2**17, (8,), **noise)
    f, density = welch(samples, fs=RATE_HZ, nperseg=2**13)
    mean = density.mean(axis=0)
    inner = (f > 12.0) & (f < 160.0)
    expected = 2 / RATE_HZ * power(shaping_filter(ColouredNoise(**noise), RATE_HZ), f[inner])
    assert slope(f[inner], mean[inner]) == pytest.approx(-exponent, abs=0.05)
    assert np.mean(mean[inner] / expected) == pytest.approx(1.0, abs=0.02)  # 2 % > 4 standard errors


def test_stationary_from_the_first_sample():
    lanes = 20_000
    samples = make(5, 60, (lanes,), exponent=1.0, low_hz=0.5, high_hz=500.0)
    five_sigma = 5 * np.sqrt(2 / lanes)
    assert samples.var(axis=0) == pytest.approx(np.ones(60), abs=five_sigma)
    assert samples.mean(axis=0) == pytest.approx(np.zeros(60), abs=5 / np.sqrt(lanes))


@pytest.mark.parametrize("exponent", EXPONENTS)
def test_covariance_of_the_state_does_not_change_over_a_step(exponent):
    sos = shaping_filter(ColouredNoise(exponent=exponent), RATE_HZ)
    n = 2 * len(sos)
    # Unit normals one at a time give the columns of a square root of the covariance; so do they after a step.
    start = stationary_state(sos, np.vstack([np.eye(n), np.zeros(n)]))
    white = np.vstack([np.zeros((n, 1)), np.ones((1, 1))])
    samples, after = colour(sos, white, start)
    before, later = (z.swapaxes(0, 1).reshape(n + 1, n) for z in (start, after))
    assert later.T @ later == pytest.approx(before.T @ before, abs=1e-7)
    assert np.sum(samples**2) == pytest.approx(1.0, abs=1e-6)


@settings(deadline=None)
@given(cuts=st.lists(st.integers(0, 300), max_size=8), lanes=st.sampled_from([(), (1,), (3,)]))
def test_same_bits_in_any_chunks(cuts, lanes):
    random = np.random.default_rng(7)
    sos = shaping_filter(ColouredNoise(exponent=1.3), RATE_HZ)
    white = random.standard_normal((*lanes, 300))
    start = stationary_state(sos, random.standard_normal((*lanes, 2 * len(sos))))
    kept = start.copy()
    whole, end = colour(sos, white, start)
    parts, zi = [], start
    for chunk in np.split(white, sorted(cuts), axis=-1):
        part, zi = colour(sos, chunk, zi)
        parts.append(part)
    assert np.array_equal(np.concatenate(parts, axis=-1), whole)
    assert np.array_equal(zi, end)
    assert np.array_equal(start, kept)


def test_same_bits_alone_and_among_other_lanes():
    random = np.random.default_rng(9)
    sos = shaping_filter(ColouredNoise(), RATE_HZ)
    normals, white = random.standard_normal((5, 2 * len(sos))), random.standard_normal((5, 200))
    together, _ = colour(sos, white, stationary_state(sos, normals))
    for lane in range(5):
        alone, _ = colour(sos, white[lane], stationary_state(sos, normals[lane]))
        assert np.array_equal(alone, together[lane])


def test_a_state_of_another_filter_is_refused():
    sos = shaping_filter(ColouredNoise(), RATE_HZ)
    with pytest.raises(ValueError, match="zi"):
        colour(sos, np.zeros(4), np.zeros((1, 2)))
