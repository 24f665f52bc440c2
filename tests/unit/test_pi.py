"""The PI law: by hand, against plain Python, and what conditional integration must never and always do."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.pi import PiGains, PiState, linearise_pi, pi_step
from frictionloop.sensing.measurement import Measurement


def tick(integral, measured, setpoint, gains, dt):
    state, command = pi_step(PiState(integral), Measurement(measured), setpoint, gains, dt)
    return state.integral, command.u, command.saturated


def in_plain_python(integral, measured, setpoint, gains, dt):
    """The text of the contract: u = clip(v); I += ki Ts e unless the clamp is active and e pushes further into it."""
    e = setpoint - measured
    v = gains.kp * e + integral
    u = gains.low if v < gains.low else gains.high if v > gains.high else v
    into_the_top = v > gains.high and e > 0
    into_the_bottom = v < gains.low and e < 0
    if not (into_the_top or into_the_bottom):
        integral = integral + gains.ki * dt * e
    return integral, u, float(v != u)


def test_a_sequence_by_hand():
    """kp = 2, ki = 4 1/s, dt = 1/8 s, so I grows by e/2. Every number is a binary fraction, so equality is exact."""
    gains = PiGains(2.0, 4.0, 0.125, 1.0)
    by_hand = [  # f_r, f_m, then I afterwards, u, saturated
        (0.75, 0.50, 0.125, 0.500, 0.0),  # v = 2/4 + 0
        (0.75, 0.50, 0.250, 0.625, 0.0),  # v = 2/4 + 1/8
        (1.00, 0.50, 0.250, 1.000, 1.0),  # v = 1 + 1/4, above; e > 0 pushes further, I stays
        (0.50, 0.75, 0.250, 0.125, 1.0),  # v = -1/2 + 1/4, below; e < 0 pushes further, I stays
        (0.75, 0.75, 0.250, 0.250, 0.0),  # v = 0 + 1/4
        (0.50, 0.50, 0.250, 0.250, 0.0),  # no error, no change
        (0.50, 0.5625, 0.21875, 0.125, 0.0),  # v = -1/8 + 1/4: on the edge of the clamp, not beyond
    ]
    integral = 0.0
    for r, m, after, u, saturated in by_hand:
        integral, *out = tick(integral, m, r, gains, 0.125)
        assert (integral, *out) == (after, u, saturated)


# Multiples of 2^-10 below 2^5: products and sums are exact in double precision, so all comparisons are.
dyadic = st.integers(-(2**12), 2**12).map(lambda n: n / 2**10)
gain = st.integers(0, 2**10).map(lambda n: n / 2**5)
steps_per_s = st.sampled_from([2.0**-3, 2.0**-10, 2.0**-12])


@st.composite
def limits(draw):
    low = draw(st.integers(0, 2**10)) / 2**10
    return low, low + draw(st.integers(1, 2**10)) / 2**10


@given(dyadic, dyadic, dyadic, gain, gain, limits(), steps_per_s)
def test_one_step_equals_plain_python(integral, measured, setpoint, kp, ki, clamp, dt):
    gains = PiGains(kp, ki, *clamp)
    assert tick(integral, measured, setpoint, gains, dt) == in_plain_python(integral, measured, setpoint, gains, dt)


@given(dyadic, dyadic, dyadic, gain, gain, limits(), steps_per_s)
def test_the_integral_never_moves_further_into_an_active_clamp(integral, measured, setpoint, kp, ki, clamp, dt):
    after, u, saturated = tick(integral, measured, setpoint, PiGains(kp, ki, *clamp), dt)
    if saturated and u == clamp[1]:
        assert after <= integral
    if saturated and u == clamp[0]:
        assert after >= integral
    if not saturated:
        assert after == integral + ki * dt * (setpoint - measured)


@given(dyadic, dyadic.filter(bool), gain, gain.filter(bool), limits(), steps_per_s)
def test_the_integral_leaves_the_clamp_at_once(measured, error, kp, ki, clamp, dt):
    """An error that points out of the clamp is integrated in the same period, however deep the clamp."""
    # An integral that holds v beyond the clamp against the error's own proportional part.
    integral = clamp[1] - kp * error + 1.0 if error < 0 else clamp[0] - kp * error - 1.0
    after, u, saturated = tick(integral, measured, measured + error, PiGains(kp, ki, *clamp), dt)
    assert (u, saturated) == (clamp[1] if error < 0 else clamp[0], 1.0)
    assert after == integral + ki * dt * error


def test_no_windup_over_a_long_saturation():
    gains = PiGains(1.0, 100.0, 0.1, 0.8)
    integral = 0.5
    for _ in range(10_000):
        integral, u, _ = tick(integral, 0.2, 0.6, gains, 2e-4)
    assert u == 0.8
    assert integral <= 0.8  # a plain integrator would hold 0.5 + 100 * 0.4 * 2 = 80.5 by now
    _, u, saturated = tick(integral, 0.9, 0.6, gains, 2e-4)
    assert (u < 0.8, saturated) == (True, 0.0)  # the first error of the other sign is answered at once


@pytest.mark.parametrize(("v", "u", "saturated"), [(0.1, 0.1, 0.0), (0.8, 0.8, 0.0), (0.5, 0.5, 0.0)])
def test_a_command_on_the_edge_of_the_clamp_is_not_saturated(v, u, saturated):
    assert tick(v, 0.0, 0.0, PiGains(1.0, 0.0, 0.1, 0.8), 2e-4) == (v, u, saturated)


def test_frequency_response_and_delay():
    pi = linearise_pi(fl.PiController(kp=10.0, ki=2.0, delay_s=1e-3))
    f = np.array([0.01, 1.0, 250.0])
    expected = (10.0 + 2.0 / (2j * np.pi * f)) * np.exp(-2j * np.pi * f * 1e-3)
    np.testing.assert_allclose(pi.response(f), expected, rtol=1e-13)
    assert abs(pi.response(np.array([1e4]))[0]) == pytest.approx(10.0, rel=1e-9)
