"""The small linear system against SciPy's and against its own algebra."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import freqs

from frictionloop.quantities import Lti

FREQUENCY_HZ = np.geomspace(0.1, 1e4, 60)
coefficient = st.floats(0.01, 100)
polynomial = st.lists(coefficient, min_size=1, max_size=4).map(tuple)
# Positive coefficients, degree 1 or 2: every root lies left of the imaginary axis, so H is finite on it.
system = st.builds(
    Lti, polynomial, st.lists(coefficient, min_size=2, max_size=3).map(tuple), st.floats(0, 1e-2, allow_subnormal=False)
)


@given(system)
def test_response_equals_scipys(lti):
    _, rational = freqs(lti.num, lti.den, 2 * np.pi * FREQUENCY_HZ)
    expected = rational * np.exp(-2j * np.pi * FREQUENCY_HZ * lti.delay_s)
    # Both evaluate the same polynomials; 1e-12 leaves room for Horner's rule in another order.
    np.testing.assert_allclose(lti.response(FREQUENCY_HZ), expected, rtol=1e-12)


@given(system, system)
def test_series_connection_multiplies_responses(one, other):
    both = (one * other).response(FREQUENCY_HZ)
    # The product polynomial has up to 6 terms, each rounded; near the imaginary axis roots lose a few digits.
    np.testing.assert_allclose(both, one.response(FREQUENCY_HZ) * other.response(FREQUENCY_HZ), rtol=1e-8)


def test_a_pure_delay_turns_the_phase_only():
    delay = Lti((1.0,), (1.0,), 1e-3)
    assert delay.response(np.array([250.0]))[0] == pytest.approx(-1j, abs=1e-15)  # a quarter of 4 ms


def test_scalars_and_arrays_of_any_shape():
    lowpass = Lti((1.0,), (1.0 / (2 * np.pi * 100.0), 1.0))
    assert lowpass.response(0.0) == 1.0
    assert abs(lowpass.response(100.0)) ** 2 == pytest.approx(0.5, rel=1e-14)
    assert lowpass.response(np.ones((2, 3))).shape == (2, 3)


def test_it_is_a_value():
    lti = Lti((1.0,), (1.0, 2.0))
    assert lti == Lti((1.0,), (1.0, 2.0))
    with pytest.raises(dataclasses.FrozenInstanceError):
        lti.delay_s = 1.0
