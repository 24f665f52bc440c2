"""The skin alone: its static stiffness, its poles, and the books of energy that the midpoint rule keeps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contact_constants import constants_of
from hypothesis import given
from hypothesis import strategies as st
from stored_energy import skin_energy_j

from frictionloop.physics.bristle_contact import ContactState, bristle_step

DT, K, C, M = 2e-5, 1e3, 1.0, 1e-4


def skin_step(lag, lag_speed, force, k, c, m, dt):
    """Return lag and speed after a step of a bone that goes so fast that the contact slides at a given force."""
    constants = constants_of(dt, k, c, m, 1000.0)  # a bristle so long that the midpoint rule resolves it
    after, mean = bristle_step(ContactState(lag, lag_speed, force), abs(force), math.copysign(1e9, force), constants)
    assert mean == force
    return after[:2]


@given(
    lag=st.floats(-1e-3, 1e-3),
    lag_speed=st.floats(-1, 1),
    force=st.one_of(st.floats(1e-6, 2), st.floats(-2, -1e-6)),
    k=st.floats(100, 1e4),
    c=st.floats(0, 10),
    m=st.floats(1e-5, 1e-3),
    dt=st.floats(1e-6, 1e-4),
)
def test_work_is_what_spring_and_mass_gain_and_the_damper_takes(lag, lag_speed, force, k, c, m, dt):
    after, speed_after = skin_step(lag, lag_speed, force, k, c, m, dt)
    moved = after - lag
    before_j, after_j = skin_energy_j(lag, lag_speed, k, m), skin_energy_j(after, speed_after, k, m)
    damped_j = c * moved**2 / dt
    # Rounding: a few EPS of each term, where moved is a difference of lags.
    lags = abs(lag) + abs(after)
    slack = 1e-14 * (before_j + after_j + damped_j + (abs(force) + 2 * c * abs(moved) / dt) * (lags + abs(moved)))
    assert after_j + damped_j - before_j == pytest.approx(force * moved, rel=0, abs=10 * slack)


def test_the_response_to_a_force_is_that_of_the_differential_equation():
    """Force 0.5 N from rest: x = F/k (1 - (p2 e^(p1 t) - p1 e^(p2 t))/(p2 - p1)), over-damped."""
    p1, p2 = np.roots([M, C, K])
    lag, speed, worst = 0.0, 0.0, 0.0
    for n in range(1, 500):
        lag, speed = skin_step(lag, speed, 0.5, K, C, M, DT)
        t = n * DT
        exact = 0.5 / K * (1 - (p2 * math.exp(p1 * t) - p1 * math.exp(p2 * t)) / (p2 - p1))
        worst = max(worst, abs(lag - exact))
    # The rule turns a pole p into p (1 + (p dt)^2/12); p t e^(p t) is at most 1/e, for the fast pole the larger.
    assert worst < 0.5 / K * (p1 * DT) ** 2 / 12 / math.e
    assert lag == pytest.approx(0.5 / K, rel=1e-4)
