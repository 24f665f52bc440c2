"""The step of the contact against closed forms, its mirror image, and where numbers run out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contact_constants import constants_of
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from frictionloop.parameters import Skin
from frictionloop.physics.bristle_contact import TINY, ContactState, bristle_step, linearise_slip

K, C, M, DT = 1e3, 1.0, 1e-4, 2e-5
STIFF = 1e12
"""Stiffness of a skin that hardly gives, N/m: the tip then goes as the bone does."""
LENGTHS_UM = (0.0, 11.5, 30.0)
lengths = st.one_of(st.just(0.0), st.floats(0.0, 1000.0))
states = st.builds(ContactState, st.floats(-1e-3, 1e-3), st.floats(-1, 1), st.floats(-2, 2), st.floats(0, 100))
limits = st.one_of(st.floats(0, 2), st.just(0.0), st.floats(-1, 0))
speeds = st.one_of(st.just(0.0), st.floats(-1, 1))


def mirrored(state):
    """What points along the glass turns its sign; how old the contact is does not."""
    return ContactState(-state.lag_m, -state.lag_speed_m_s, -state.force_n, state.age_s)


def forces(state, limit, speed, constants, count):
    found = []
    for _ in range(count):
        state, mean = bristle_step(ContactState(*state), limit, speed, constants)
        found.append((state[2], mean))
    return np.array(found).T


@pytest.mark.parametrize("length_um", LENGTHS_UM)
@pytest.mark.parametrize("speed", [0.02, -0.15])
def test_steady_sliding_is_at_the_limit_to_the_last_bit(length_um, speed):
    limit = 0.5
    at = math.copysign(limit, speed)
    own, mean = forces((at / K, 0.0, at), limit, speed, constants_of(DT, K, C, M, length_um), 100)
    assert (own == at).all() and (mean == at).all()


@pytest.mark.parametrize("start", [0.1, 0.5, 0.0, -0.5])
def test_the_gap_to_the_limit_dies_as_e_to_the_way_over_the_length(start):
    """F = Fc + (F0 - Fc) e^(-x/z), forwards; a Pade approximant of third order of each step's way."""
    limit, speed, length = 0.3, 0.02, 11.5e-6
    constants = constants_of(DT, STIFF, C, M, 1e6 * length)
    found, _ = forces((start / STIFF, 0.0, start), limit, speed, constants, 100)
    way = speed * DT * np.arange(1, 101)
    exact = limit + (start - limit) * np.exp(-way / length)
    assert np.abs(found - exact).max() < 1e-5


def test_back_and_forth_follows_the_branches_of_the_loop():
    """Loading to F1 and unloading over the same way: Fc (1 - e^-q), then -Fc + (F1 + Fc) e^-q."""
    limit, speed, length, count = 0.4, 0.03, 20e-6, 50
    constants = constants_of(DT, STIFF, C, M, 1e6 * length)
    q = speed * DT * count / length
    up, _ = forces((0.0, 0.0, 0.0), limit, speed, constants, count)
    down, _ = forces((up[-1] / STIFF, 0.0, up[-1]), limit, -speed, constants, count)
    assert up[-1] == pytest.approx(limit * (1 - math.exp(-q)), rel=1e-4)
    assert down[-1] == pytest.approx(-limit + (up[-1] + limit) * math.exp(-q), abs=1e-4)


@given(states, st.floats(1e-6, 2), speeds)
def test_without_a_length_it_is_the_return_mapping(state, limit, speed):
    """It sticks with free/y while that is within the limit, else the force is the limit, whatever it was before."""
    constants = constants_of(DT, K, C, M, 0.0)
    lag, lag_speed, *_ = state
    free = DT * speed + constants.elastic * lag - constants.inertia * lag_speed
    after, mean = bristle_step(state, limit, speed, constants)
    expected = min(max(free / constants.yielding, -limit), limit)
    # A stuck force is what the sum of terms as large as 2 m x'/dt leaves.
    rounding = 1e-14 * (1 + (abs(DT * speed) + abs(constants.elastic * lag) + abs(lag_speed) * DT) / constants.yielding)
    assert mean == pytest.approx(expected, abs=rounding)
    assert after[2] == mean
    if abs(free) > constants.yielding * limit * (1 + 1e-9):
        assert abs(mean) == pytest.approx(limit, rel=1e-14)


@given(states, limits, speeds, lengths)
def test_a_mirrored_step_is_mirrored_bit_for_bit(state, limit, speed, length_um):
    constants = constants_of(DT, K, C, M, length_um)
    there = bristle_step(state, limit, speed, constants)
    back = bristle_step(mirrored(state), limit, -speed, constants)
    assert back == (mirrored(there[0]), -there[1])


@given(states, limits, speeds, lengths)
def test_a_force_goes_towards_the_limit_and_is_a_number(state, limit, speed, length_um):
    constants = constants_of(DT, K, C, M, length_um)
    after, mean = bristle_step(state, limit, speed, constants)
    assert all(map(math.isfinite, (*after, mean)))
    most = max(limit, abs(state.force_n)) if limit > 0 else 0.0
    assert abs(mean) <= most * (1 + 1e-12) + TINY  # a smaller force has lost digits
    # Half a step on, where the mean is at the limit: a way that turns out other than at first thought may go beyond.
    assert abs(after.force_n) <= 3.0 * most + TINY
    assert after.age_s == state.age_s


@pytest.mark.parametrize("length_um", [0.0, 1e-9, 11.5])
def test_nothing_moves_and_nothing_rubs(length_um):
    constants = constants_of(DT, K, C, M, length_um)
    assert bristle_step(ContactState(0.0, 0.0, 0.0), 0.0, 0.0, constants) == (ContactState(0.0, 0.0, 0.0), 0.0)
    assert bristle_step(ContactState(0.0, 0.0, 0.0), 0.5, 0.0, constants) == (ContactState(0.0, 0.0, 0.0), 0.0)


def test_at_rest_a_bristle_holds_on_beyond_a_fallen_limit_and_a_slider_lets_go():
    start = (0.5 / K, 0.0, 0.5)
    held, _ = forces(start, 0.2, 0.0, constants_of(DT, K, C, M, 11.5), 1)
    let_go, _ = forces(start, 0.2, 0.0, constants_of(DT, K, C, M, 0.0), 1)
    assert held[0] == pytest.approx(0.5, rel=1e-12) and let_go[0] == pytest.approx(0.2, rel=1e-12)


def test_a_tip_that_sticks_without_a_length_does_not_ring():
    """It lands at once from a slide at 150 mm/s: stuck, the force is c w + k x, in the middle of each step."""
    speed, steps = 0.15, 40
    _, mean = forces((0.0, 0.0, 0.0), 2.0, speed, constants_of(DT, K, C, M, 0.0), steps)
    exact = C * speed + K * speed * DT * (np.arange(steps) + 0.5)
    assert mean[1:] == pytest.approx(exact[1:], rel=1e-9)


@njit(error_model="numpy")
def run(state, limits, speed, coefficients):
    forces = np.empty(limits.size)
    for i in range(limits.size):
        state, forces[i] = bristle_step(state, limits[i], speed, coefficients)
    return forces


def simulated(length_um, limit, speed, frequency, dt):
    """Return F/Fc for a limit modulated by 1e-6 of itself, from five periods after 40 ms."""
    per_period = round(1 / (frequency * dt))
    settle = per_period * math.ceil(0.04 * frequency)
    wave = np.exp(2j * np.pi * frequency * (np.arange(settle + 5 * per_period) + 0.5) * dt)
    start = math.copysign(limit, speed)
    state = ContactState(start / K, 0.0, start)
    forces = run(state, limit * (1 + 1e-6 * wave.imag), speed, constants_of(dt, K, C, M, length_um))
    forces *= math.copysign(1.0, speed)
    return np.mean((forces[settle:] - limit) * np.conj(wave[settle:])) * 2j / (1e-6 * limit)


@pytest.mark.parametrize("length_um", [0.0, 11.5, 30.0])
@pytest.mark.parametrize("limit", [0.3, 0.7])
@pytest.mark.parametrize("speed", [0.02, -0.02, 0.15])
@pytest.mark.parametrize("frequency", [20.0, 100.0, 500.0])
def test_frequency_response(length_um, limit, speed, frequency):
    """Steps of 20 us are off by less than 0.1 % of Fc, and at least second order takes steps to the linear law."""
    expected = complex(linearise_slip(Skin(slip_length_um=length_um), limit, speed).response(frequency))
    coarse, fine = (abs(simulated(length_um, limit, speed, frequency, dt) - expected) for dt in (DT, DT / 4))
    assert coarse < 1e-3
    assert fine < coarse / 12 + 1e-9  # rounding of a force modulated by 1e-6


def test_the_cutoff_rises_with_speed_as_it_was_measured():
    """13.8 Hz per mm/s (arXiv 2505.11162), whatever the force."""
    for speed in (0.02, 0.15):
        law = linearise_slip(Skin(), 0.5, -speed)
        assert law.response(0.0) == 1.0
        assert abs(law.response(13.8 * 1e3 * speed)) == pytest.approx(math.sqrt(0.5), rel=2e-3)
