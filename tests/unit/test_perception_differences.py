"""Slow errors against published figures."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.perception import slow_error_felt
from frictionloop.quantities import FrictionloopError


def test_slow_errors_of_g5():
    np.testing.assert_array_equal(slow_error_felt([0.032, 0.034, -0.034], 0.3), [False, True, True])
    np.testing.assert_array_equal(slow_error_felt([0.098, -0.1], [0.9, 0.9]), [False, True])
    assert not np.any(slow_error_felt(0.020, [0.3, 0.6, 0.9]))  # the paper's closed loop, its three levels
    assert np.all(slow_error_felt(0.25, [0.3, 0.6, 0.9]))  # its open loop


@given(st.floats(-1, 1), st.floats(0, 2))
def test_the_sign_of_an_error_does_not_matter(error, force):
    assert slow_error_felt(error, force) == slow_error_felt(-error, force)


@pytest.mark.parametrize("bad", [-0.1, math.nan, "x"])
def test_a_force_is_not_negative(bad):
    with pytest.raises(FrictionloopError, match=r"^force_n = "):
        slow_error_felt(0.01, bad)


def test_errors_are_finite():
    with pytest.raises(FrictionloopError, match=r"^error_n = inf N: must be finite$"):
        slow_error_felt(math.inf, 0.5)
