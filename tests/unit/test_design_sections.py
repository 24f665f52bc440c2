"""Controllers as sections: against the state space they come from, their bounds, and what Q31 cannot hold."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter, sosfilt, zpk2ss

from frictionloop.design.second_order_sections import factorise
from frictionloop.design.slicot import Quadruple

PERIOD_S = 2e-4
F = np.append(np.geomspace(0.1, 2499.0, 400), 2500.0)
Z = np.exp(2j * np.pi * F * PERIOD_S)
inside = st.floats(-0.98, 0.98)
pairs = st.tuples(st.floats(0.05, 0.98), st.floats(0.02, 3.1)).map(
    lambda p: [p[0] * np.exp(1j * p[1] * s) for s in (1, -1)]
)


@st.composite
def filters(draw: st.DrawFn) -> tuple[Quadruple, np.ndarray, np.ndarray, float]:
    """A stable filter of at most 12 states with a direct path, whose poles and zeros lie apart, and these."""
    poles = [*np.ravel(draw(st.lists(pairs, max_size=4))), *draw(st.lists(inside, max_size=4))]
    zeros = [*np.ravel(draw(st.lists(pairs, min_size=len(poles) // 2, max_size=len(poles) // 2)))]
    zeros += draw(st.lists(inside, min_size=len(poles) % 2, max_size=len(poles) % 2))
    gain = draw(st.floats(1e-3, 1e3))
    poles, zeros = np.array(poles, dtype=complex), np.array(zeros, dtype=complex)
    apart = np.abs(poles[:, None] - poles[None, :]) + 9 * np.eye(len(poles))
    if poles.size and apart.min() < 0.02:
        poles = poles[:0]
        zeros = zeros[:0]
    if not poles.size:  # zpk2ss would make up a state
        empty = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.array([[gain]])
        return Quadruple(*empty), zeros[:0], poles, gain
    gain *= draw(st.sampled_from([1.0, -1.0]))
    return Quadruple(*zpk2ss(zeros, poles, gain)), zeros, poles, gain


@settings(max_examples=60)
@given(made=filters(), kp=st.floats(0.01, 10), ki=st.floats(0, 500))
def test_sections_are_the_filter_and_hold_their_bounds(made, kp, ki) -> None:
    filter_, zeros, poles, gain = made
    found = factorise(filter_, kp, ki, PERIOD_S)
    wanted = gain * np.prod(Z[:, None] - zeros, axis=1) / np.prod(Z[:, None] - poles, axis=1)
    wanted = wanted * (kp + ki * PERIOD_S / (Z - 1))
    assert found.response(F) == pytest.approx(wanted, rel=1e-4, abs=1e-6 * np.abs(wanted).max())
    assert len(found.sections) == (len(poles) + 1) // 2
    assert found.kp > 0 and found.ki >= 0  # which the law refuses otherwise
    so_far = 1.0
    for b0, b1, b2, a1, a2 in found.sections:
        assert max(map(abs, (b0, b1, b2, a1, a2))) <= 2.0
        assert abs(a2) < 1 and abs(a1) < 1 + a2  # the triangle of stable sections
        so_far = so_far * (b0 + b1 / Z + b2 / Z**2) / (1 + a1 / Z + a2 / Z**2)
        assert np.abs(so_far).max() <= 1 + 1e-2


def test_sections_run_as_the_state_space_does() -> None:
    rng = np.random.default_rng(0)
    filter_ = Quadruple(
        *zpk2ss(
            [0.9, 0.5, 0.97 * np.exp(0.2j), 0.97 * np.exp(-0.2j), -0.6],
            [0.99, -0.3, 0.8 * np.exp(0.3j), 0.8 * np.exp(-0.3j), 0.2],
            3.0,
        )
    )
    cascade, e = factorise(filter_, 0.7, 90.0, PERIOD_S), rng.normal(size=400)
    x, filtered = np.zeros(5), []
    for value in e:
        filtered.append(float((filter_.C @ x + filter_.D[0] * value)[0]))
        x = filter_.A @ x + filter_.B[:, 0] * value
    wanted = 0.7 * np.array(filtered) + lfilter([0.0, 90.0 * PERIOD_S], [1.0, -1.0], filtered)
    sos = np.array([[*s[:3], 1.0, *s[3:]] for s in cascade.sections])
    y = sosfilt(sos, e)
    found = cascade.kp * y + lfilter([0.0, cascade.ki * PERIOD_S], [1.0, -1.0], y)
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max())


def test_no_sections_is_a_pi() -> None:
    empty = Quadruple(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.array([[2.0]]))
    found = factorise(empty, 0.5, 60.0, PERIOD_S)
    assert (found.kp, found.ki, found.sections) == (1.0, 120.0, ())
    assert found.overrides["controller.kind"] == "filtered_pi"
