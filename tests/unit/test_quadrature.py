"""Gauss-Lobatto nodes, and weights that integrate polynomials against the sensor's exponential."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from frictionloop.loop.kernel.period_quadrature import (
    NODES,
    gauss_lobatto,
    product_weights,
    segment_lengths,
    segment_nodes,
    segment_weights,
    segments_needed,
)


def test_the_textbook_rules():
    # Abramowitz and Stegun, table 25.6, moved from [-1, 1] to [0, 1].
    x, w = gauss_lobatto(3)
    np.testing.assert_allclose(x, [0, 0.5, 1], atol=1e-15)
    np.testing.assert_allclose(w, [1 / 6, 4 / 6, 1 / 6], rtol=1e-14)
    x, w = gauss_lobatto(4)
    np.testing.assert_allclose(2 * x - 1, [-1, -math.sqrt(1 / 5), math.sqrt(1 / 5), 1], atol=1e-14)
    np.testing.assert_allclose(2 * w, [1 / 6, 5 / 6, 5 / 6, 1 / 6], rtol=1e-14)


@pytest.mark.parametrize("nodes", [2, 3, 4, 5, 6, 7, 8])
def test_exact_up_to_degree_2n_minus_3_and_no_further(nodes):
    x, w = gauss_lobatto(nodes)
    for degree in range(2 * nodes - 2):
        assert w @ x**degree == pytest.approx(1 / (degree + 1), rel=1e-13)
    assert abs(w @ x ** (2 * nodes - 2) - 1 / (2 * nodes - 1)) > 1e-9


def moment(theta, degree):
    """Return int_0^1 theta e^(-theta y) (1 - y)^degree dy, y = 1 - x, by adaptive quadrature."""
    reach = min(1.0, 50.0 / theta)  # e^-50 = 2e-22 beyond
    return quad(lambda y: theta * math.exp(-theta * y) * (1 - y) ** degree, 0.0, reach, epsabs=1e-15, epsrel=1e-13)[0]


@pytest.mark.parametrize("theta", [1e-9, 1e-3, 0.3, 1.2566, 12.566, 125.66, 1e4, 1e6])
def test_product_weights_are_exact_for_polynomials(theta):
    x, _ = gauss_lobatto()
    weights = product_weights(theta)
    for degree in range(NODES):
        # 48 Gauss points over up to 40 time constants: converged, with their weights rounded to 1e-13 of the sum.
        assert weights @ x**degree == pytest.approx(moment(theta, degree), rel=3e-13, abs=1e-15)
    # In closed form for a constant: what a reading at rest keeps of itself and gains must sum to 1.
    assert weights.sum() == pytest.approx(-math.expm1(-theta), rel=3e-13)


period = st.floats(1e-5, 1e-2)
share = st.floats(0.01, 0.99)
counts = st.integers(1, 5)


@given(period, share, counts, counts, st.floats(1.0, 1e5))
def test_the_weights_of_a_period_in_pieces_sum_to_what_the_sensor_gains(length, where, before, after, cutoff_hz):
    weights = segment_weights(cutoff_hz, where * length, length, before, after)
    assert weights.shape == (5 * (before + after) + 1,)
    omega = 2 * math.pi * cutoff_hz
    # Ends of the pieces are rounded at the size of the period, which the exponential turns into omega T 2^-52 each.
    rounding = 3e-13 + 2 * (before + after) * omega * length * 2.0**-52
    assert weights.sum() == pytest.approx(-math.expm1(-omega * length), rel=rounding)


@given(period, share, counts, counts)
def test_a_slow_sensor_integrates_over_the_period(length, where, before, after):
    """For ws T -> 0 the weights are ws times a plain rule: exact for polynomials up to degree 5 in every piece."""
    omega = 1e-9 / length
    weights = segment_weights(omega / (2 * math.pi), where * length, length, before, after)
    times = segment_nodes(where * length, length, before, after)
    for degree in range(NODES):
        integral = (weights / omega) @ (times / length) ** degree / length
        assert integral == pytest.approx(1 / (degree + 1), rel=1e-8)  # ws T = 1e-9 itself is the first neglected term


@given(period, share, counts, counts)
def test_nodes_run_through_the_period_and_restart_at_the_switch(length, where, before, after):
    switch = where * length
    times = segment_nodes(switch, length, before, after)
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(length, rel=1e-14)
    assert np.all(np.diff(times) > 0)
    assert times[5 * before] == pytest.approx(switch, rel=1e-14)
    lengths = segment_lengths(switch, length, before, after).tolist()
    assert lengths == pytest.approx([switch / before] * before + [(length - switch) / after] * after, rel=1e-14)
    np.testing.assert_allclose(times[::5], np.concatenate([[0.0], np.cumsum(lengths)]), rtol=1e-13)


def test_segments_follow_the_plate():
    assert segments_needed(100.0, 0.0) == 0
    assert segments_needed(1e-9, 2e-4) == 1
    assert segments_needed(100.0, 2e-4) == 1  # the paper's plate and rate: 0.02 of its cutoff period
    for n in (1, 2, 7):
        assert segments_needed(100.0, 0.035 / 100.0 * (n - 0.01)) == n
