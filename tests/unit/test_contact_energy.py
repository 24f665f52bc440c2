"""No law of the contact ever gives energy: per step, around closed paths, with the skin, and a law that does is caught.

The work on the contact in a step is the mean force times the way of the tip over the glass, dt w - (x1 - x0).
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from contact_constants import constants_of
from hypothesis import given
from hypothesis import strategies as st
from stored_energy import bristle_energy_j, skin_energy_j

from frictionloop.physics.contact import ContactState
from frictionloop.physics.contact_laws import dahl_step, lugre_step, slider_step

STEPS = {"dahl": dahl_step, "lugre": lugre_step, "slider": slider_step}
each_law = pytest.mark.parametrize("law", STEPS)
K, C, M, S0, S1, DT = 1e3, 1.0, 1e-4, 2e4, 1.4, 2e-5
TINY = 1e-300
"""Below this, numbers lose digits."""
COEFFICIENTS = constants_of(DT, K, C, M, S0, S1)

parameters = st.tuples(
    st.floats(1e-6, 1e-3),  # dt
    st.floats(100, 1e4),  # k
    st.floats(0, 10),  # c
    st.floats(1e-5, 1e-3),  # m
    st.floats(1e3, 1e6),  # s0
    st.floats(0, 1e3),  # s1
)
states = st.builds(ContactState, st.floats(-1e-3, 1e-3), st.floats(-1, 1), st.floats(-1e-3, 1e-3), st.floats(0, 1e-3))
limits = st.one_of(st.floats(0, 2), st.floats(0, 1e-6), st.just(0.0))
speeds = st.floats(-1, 1)


def dissipated_j(step, state, limit, speed, coefficients):
    """Return work less gain of the bristle in a step, what rounding may make of it, and where the step ends."""
    after, force = step(state, limit, speed, coefficients)
    dt, s0 = coefficients.dt, coefficients.bristle
    way = dt * speed - (after[0] - state[0])
    gained = bristle_energy_j(after[2], s0) - bristle_energy_j(state[2], s0)
    ways = abs(dt * speed) + abs(dt * state[1]) + abs(state[0]) + abs(after[0]) + abs(state[2]) + abs(after[2])
    slack = 1e-14 * (abs(force) + s0 * (abs(state[2]) + abs(after[2]))) * ways
    return force * way - gained, slack, ContactState(*after)


@each_law
@given(parameters, states, limits, speeds)
def test_a_step_never_gives_energy(law, values, state, limit, speed):
    """Whatever the parameters, the step, the state (also beyond the limit) and the speed."""
    dissipated, slack, _ = dissipated_j(STEPS[law], state, limit, speed, constants_of(*values))
    assert dissipated >= -slack - TINY


@each_law
@given(parameters, states, st.lists(limits, min_size=1, max_size=4))
def test_a_bone_at_rest_leaves_energy_to_die(law, values, state, steps):
    """With w = 0 the energy of skin and bristle never grows, at a constant limit or a changing one."""
    constants = constants_of(*values)
    _, k, _, m, s0, _ = values

    def energy(state):
        return float(skin_energy_j(state[0], state[1], k, m) + bristle_energy_j(state[2], s0))

    for limit in np.repeat(steps, 5):
        before = energy(state)
        state, _ = STEPS[law](state, limit, 0.0, constants)
        assert energy(state) <= before * (1 + 1e-11) + TINY
        state = ContactState(*state)


@each_law
@given(st.floats(0.05, 1), st.lists(st.floats(-0.2, 0.2), min_size=2, max_size=6))
def test_a_closed_path_at_constant_load_costs_energy(law, limit, speeds):
    """The bone repeats a closed path; once the tip does too, a round has cost the hand work."""
    path = np.repeat([*speeds, -sum(speeds)], 20)
    state, work = ContactState(0.0, 0.0, 0.0), 0.0
    for _ in range(6):
        start, work, lost = state, 0.0, 0.0
        for speed in path:
            after, force = STEPS[law](state, limit, speed, COEFFICIENTS)
            moved = after[0] - state[0]
            work += force * (DT * speed - moved)
            lost += C * moved**2 / DT
            state = ContactState(*after)
    gained = bristle_energy_j(state[2], S0) - bristle_energy_j(start[2], S0)
    assert work >= gained - 1e-15
    assert work + lost >= gained - 1e-15


def test_a_slow_round_of_the_slider_costs_its_hysteresis_loop():
    """A bone that goes back and forth by 2 X costs 4 Fc (X - Fc/k_s) in the contact: k_s k s0/(k + s0), slow."""
    limit, speed, half_way = 0.1, 1e-3, 0.5e-3
    steps = round(2 * half_way / (speed * DT))
    state, work = ContactState(0.0, 0.0, 0.0), 0.0
    for turn in range(4):
        for _ in range(steps):
            signed = speed if turn % 2 == 0 else -speed
            after, force = slider_step(state, limit, signed, COEFFICIENTS)
            if turn >= 2:
                work += force * (DT * signed - (after[0] - state[0]))
            state = ContactState(*after)
    series = K * S0 / (K + S0)
    # The damper's force c w moves the corners of the loop by c w/k_s at most.
    assert work == pytest.approx(4 * limit * (half_way - limit / series), abs=4 * limit * C * speed / series)


def continuous_power_w(deflection, limit, speed, damping):
    """Return F v - d/dt (s0 z^2/2) of LuGre as a differential equation."""
    rate = speed - S0 * abs(speed) * deflection / limit
    return (S0 * deflection + damping * rate) * speed - S0 * deflection * rate


def test_lugre_without_its_guard_gives_energy_and_is_caught():
    """After the limit has fallen from 0.5 to 0.05 N, s1 = 10 N s/m at 0.15 m/s: s1 |v|/Fc = 30, where 4 is passive."""
    deflection, limit, speed, s1 = 0.5 / S0, 0.05, 0.15, 10.0
    constants = constants_of(DT, K, C, M, S0, s1)
    state = ContactState(0.5 / K, 0.0, deflection)
    assert continuous_power_w(deflection, limit, speed, s1) < 0  # the law itself, not the step, gives energy
    given_, slack, _ = dissipated_j(lugre_step, state, limit, speed, constants._replace(guard=0.0))
    assert given_ < -1000 * slack
    taken, slack, _ = dissipated_j(lugre_step, state, limit, speed, constants)
    assert taken >= -slack


@given(st.floats(-10, 10), st.floats(1e-3, 2), st.floats(-1, 1), st.floats(0, 1e3))
def test_the_bound_on_lugres_damping(times_limit, limit, speed, s1):
    """Dissipation is Fc |v| (u^2 - a u + a), u = s0 z sign(v)/Fc, a = s1 |v|/Fc: never negative if a <= 4."""
    guarded = s1 / (1 + s1 * abs(speed) / (4 * limit))
    a = guarded * abs(speed) / limit
    assert a <= 4 * (1 + 1e-15)
    deflection = times_limit * limit / S0
    power = continuous_power_w(deflection, limit, speed, guarded)
    u = times_limit * math.copysign(1.0, speed)
    scale = limit * abs(speed) * (1 + u * u) * (1 + a)
    assert power == pytest.approx(limit * abs(speed) * (u * u - a * u + a), rel=0, abs=1e-14 * scale + TINY)
    assert power >= -1e-14 * scale - TINY
