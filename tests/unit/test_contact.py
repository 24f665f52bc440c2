"""The contact's laws in closed form: stuck, sliding, rising, lifted, falling limits; bits of lanes; bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contact_constants import constants_of
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from frictionloop.loop.kernel.access import doubles, load, store
from frictionloop.loop.kernel.slab import LANES
from frictionloop.physics.contact import ContactCoefficients, ContactState
from frictionloop.physics.contact_laws import dahl_step, lugre_step, slider_step

STEPS = {"dahl": dahl_step, "lugre": lugre_step, "slider": slider_step}
K, C, M, S0, S1, DT = 1e3, 1.0, 1e-4, 2e4, 1.4, 2e-5
COEFFICIENTS = constants_of(DT, K, C, M, S0, S1)
REST = ContactState(0.0, 0.0, 0.0)


def lift(step):
    @njit(error_model="numpy")
    def run(state, limits, speeds, coefficients):
        forces = np.empty(limits.size)
        for i in range(limits.size):
            state, forces[i] = step(state, limits[i], speeds[i], coefficients)
        return state, forces

    return run


RUN = {law: lift(step) for law, step in STEPS.items()}
each_law = pytest.mark.parametrize("law", STEPS)


def run(law, limit, speed, duration_s, state=REST):
    steps = round(duration_s / DT)
    limits, speeds = (np.broadcast_to(np.asarray(x, dtype=float), steps).copy() for x in (limit, speed))
    return RUN[law](state, limits, speeds, COEFFICIENTS)


@each_law
def test_a_stuck_tip_is_two_springs_in_series(law):
    """The bone moves by 50 um in 5 ms and stops; below a limit of 1e9 N nothing slides: F = X k s0/(k + s0)."""
    speed = np.where(np.arange(5000) < 250, 0.01, 0.0)
    state, forces = run(law, 1e9, speed, 0.1)
    expected = 50e-6 * K * S0 / (K + S0)
    # Dahl's and LuGre's bristles give way by a share F/Fc = 5e-11 while they load.
    assert forces[-1] == pytest.approx(expected, rel=1e-9)
    assert state[0] == pytest.approx(expected / K, rel=1e-9)


@each_law
@pytest.mark.parametrize("speed", [0.02, -0.02, 0.15, -0.15])
@pytest.mark.parametrize("limit", [0.05, 0.5])
def test_a_sliding_tip_feels_the_limit_against_its_motion(law, speed, limit):
    state, forces = run(law, limit, speed, 0.2)
    force = math.copysign(limit, speed)
    assert forces[-1] == pytest.approx(force, rel=1e-12)
    assert state[:3] == pytest.approx((force / K, 0.0, force / S0), rel=1e-9, abs=1e-12)


def test_a_rise_of_friction_takes_df_over_series_stiffness_and_speed():
    """Slider from 0.35 to 0.75 N: F = F0 + k_s w t + c w (s0/(k + s0))^2 once tip and bristle have stopped ringing."""
    speed = 0.02
    _, forces = run("slider", 0.75, speed, 0.04, ContactState(0.35 / K, 0.0, 0.35 / S0, 0.35 / S0))
    series = K * S0 / (K + S0)
    rise_s = (0.4 - C * speed * (S0 / (K + S0)) ** 2) / (series * speed)
    middles = (np.arange(forces.size) + 0.5) * DT
    # The mean of the one step with the corner in it is off by less than the way of that step, k_s w dt.
    line = 0.35 + C * speed * (S0 / (K + S0)) ** 2 + series * speed * middles
    ringing = middles < 5e-3  # decays like e^(-c t/2m), 1e-11 after 5 ms
    np.testing.assert_allclose(forces[~ringing], np.minimum(line, 0.75)[~ringing], rtol=0, atol=series * speed * DT)
    assert middles[np.argmax(forces >= 0.75)] == pytest.approx(rise_s, abs=2 * DT)


@each_law
@pytest.mark.parametrize("speed", [0.02, 0.15])
def test_friction_rises_no_faster_than_the_skin_lets_it(law, speed):
    _, forces = run(law, 0.75, speed, 0.06, ContactState(0.35 / K, 0.0, 0.35 / S0, 0.35 / S0))
    rate = np.diff(forces) / DT
    assert rate[250:].max() <= K * speed  # after the ringing of 2.3 kHz
    assert forces[-1] == pytest.approx(0.75, rel=1e-6)


@each_law
def test_a_lifted_finger_feels_nothing_and_its_skin_relaxes(law):
    state, forces = run(law, 0.0, 0.1, 0.02, ContactState(5e-4, -0.1, 3e-5, 2.5e-5))
    np.testing.assert_array_equal(forces, 0.0)
    assert state[2] == 0.0
    # m x'' + c x' + k x = 0 from x0, x'0, a sum of two exponentials; the midpoint rule errs by (slow pole dt)^2/12.
    slow, fast = np.roots([M, C, K])[::-1]
    a = (-0.1 - fast * 5e-4) / (slow - fast)
    assert state[0] == pytest.approx(a * math.exp(slow * 0.02), rel=0.02 * abs(slow) * (slow * DT) ** 2 / 12 * 1.5)
    landed, force = STEPS[law](ContactState(*state), 0.5, 0.1, COEFFICIENTS)
    assert 0 < force < (S0 * DT + S1) * (0.1 + abs(state[1]))
    assert landed[2] > 0


@each_law
@given(fall=st.floats(1e-12, 1), speed=st.floats(0.02, 0.3), periods=st.integers(1, 100))
def test_a_bristle_beyond_a_falling_limit_relaxes(law, fall, speed, periods):
    """From 0.5 N the limit falls by any factor within 20 us to 2 ms: no force grows, and the new limit is reached."""
    falling = 0.5 * fall ** np.clip(np.arange(3000) / periods, 0, 1)
    _, forces = run(law, falling, speed, 0.06, ContactState(0.5 / K, 0.0, 0.5 / S0, 0.5 / S0))
    assert np.all(np.abs(forces) <= 0.5 * (1 + 1e-9))
    # The slowest bristle has a time constant of 0.5 N/(s0 20 mm/s) = 1.25 ms, and had 58 ms.
    assert forces[-1] == pytest.approx(falling[-1], rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(("law", "force"), [("dahl", 0.5), ("lugre", 0.5), ("slider", 0.25)])
def test_only_the_slider_lets_a_resting_finger_go_when_its_limit_falls(law, force):
    """A bristle gives way by sliding: at w = 0 it holds on, in equilibrium with the skin, beyond its limit."""
    _, forces = run(law, 0.25, 0.0, 0.02, ContactState(0.5 / K, 0.0, 0.5 / S0, 0.5 / S0))
    assert forces[100] == pytest.approx(force, rel=1e-9)


@given(
    st.floats(-1e-3, 1e-3), st.floats(-1, 1), st.floats(-1e-4, 1e-4), st.floats(0, 2), st.floats(0, 2), st.floats(-1, 1)
)
def test_the_slider_never_exceeds_its_limit(lag, lag_speed, bristle, last, limit, speed):
    state, force = slider_step(ContactState(lag, lag_speed, bristle, last / S0), limit, speed, COEFFICIENTS)
    assert abs(force) <= limit + 1e-15 * (limit + last) + 1e-300
    # At the end of a step a rising limit is higher than in its middle.
    assert abs(S0 * state[2]) <= max(limit, 1.5 * limit - 0.5 * last) + 1e-15 * (limit + last) + 1e-300


def lane_values(random):
    """Return a state, inputs and constants for every lane, all different, some lifted and some beyond the limit."""
    scale = random.uniform(0.5, 2.0, (6, LANES))
    values = (scale[:5] * np.array([[K], [C], [M], [S0], [S1]])).T
    constants = np.transpose([constants_of(DT, *own) for own in values])
    state = random.uniform(-1, 1, (3, LANES)) * np.array([[1e-3], [0.2], [5e-5]])
    limits = random.uniform(-0.2, 1, LANES)
    return constants, np.vstack([state, random.uniform(0, 5e-5, LANES)]), limits, random.uniform(-0.2, 0.2, LANES)


@each_law
def test_a_tile_of_lanes_has_the_bits_of_single_fingers(law):
    step = STEPS[law]
    state_rows, limit_row, speed_row, force_row = (0, 1, 2, 3), 4, 5, 6
    constant_rows = tuple(range(7, 7 + len(ContactCoefficients._fields)))

    @njit(error_model="numpy")
    def tile(slab, n):
        s = doubles(slab.ctypes.data)
        for i in range(n):
            limit, speed = load(s, i, LANES, (limit_row, speed_row))
            constants = load(s, i, LANES, constant_rows)
            state, force = step(load(s, i, LANES, state_rows), limit, speed, constants)
            store(s, i, LANES, state_rows, state)
            store(s, i, LANES, force_row, force)

    constants, state, limits, speeds = lane_values(np.random.default_rng(3))
    slab = np.vstack([state, limits, speeds, np.zeros(LANES), *constants])
    flat = slab.ravel()
    for _ in range(50):
        tile(flat, LANES)
    for lane in range(LANES):
        alone = ContactCoefficients(*(float(c[lane]) for c in constants))
        single, force = ContactState(*state[:, lane]), 0.0
        for _ in range(50):
            single, force = step(single, limits[lane], speeds[lane], alone)
        assert (*single, force) == (*flat.reshape(slab.shape)[:4, lane], flat.reshape(slab.shape)[6, lane])
