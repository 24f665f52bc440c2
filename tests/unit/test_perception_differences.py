"""Just-noticeable differences against published figures."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.perception import force_jnd_n, friction_jnd_n, slow_error_felt, timing_felt
from frictionloop.quantities import FrictionloopError


def test_force_differences_of_the_sources():
    np.testing.assert_allclose(force_jnd_n([0.4, 0.5, 2.5]).low_n, [0.06, 0.035, 0.175], rtol=1e-14)
    np.testing.assert_allclose(force_jnd_n([0.4, 0.5, 2.5]).high_n, [0.108, 0.05, 0.25], rtol=1e-14)


@given(st.floats(0, 10))
def test_a_range_has_two_ends_in_order(force):
    low, high = force_jnd_n(force)
    assert 0 <= low <= high <= force


def test_slow_errors_of_g5():
    np.testing.assert_allclose(friction_jnd_n([0.3, 0.9]), [0.033, 0.099], rtol=1e-14)
    np.testing.assert_array_equal(slow_error_felt([0.032, 0.034, -0.034], 0.3), [False, True, True])
    np.testing.assert_array_equal(slow_error_felt([0.098, -0.1], [0.9, 0.9]), [False, True])
    assert not np.any(slow_error_felt(0.020, [0.3, 0.6, 0.9]))  # the paper's closed loop, its three levels
    assert np.all(slow_error_felt(0.25, [0.3, 0.6, 0.9]))  # its open loop


@given(st.floats(-1, 1), st.floats(0, 2))
def test_the_sign_of_an_error_does_not_matter(error, force):
    assert slow_error_felt(error, force) == slow_error_felt(-error, force)


def test_timing():
    np.testing.assert_array_equal(timing_felt([0.0, 2e-3, -2e-3, 2.4e-3, -5e-3]), [False, False, False, True, True])


@pytest.mark.parametrize("call", [force_jnd_n, friction_jnd_n, lambda f: slow_error_felt(0.01, f)])
@pytest.mark.parametrize("bad", [-0.1, math.nan, "x"])
def test_a_force_is_not_negative(call, bad):
    with pytest.raises(FrictionloopError, match=r"^force_n = "):
        call(bad)


def test_errors_and_times_are_finite():
    with pytest.raises(FrictionloopError, match=r"^error_n = inf N: must be finite$"):
        slow_error_felt(math.inf, 0.5)
    with pytest.raises(FrictionloopError, match=r"^difference_s = nan s: must be finite$"):
        timing_felt(math.nan)
