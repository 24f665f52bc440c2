"""The contact never gives energy at a constant limit: per step, around closed paths, and with the skin.

The work on the contact in a step is the mean force times the way of the tip over the glass, dt w - (x1 - x0). The
bristle holds z F^2/(2 Fc).
"""

from __future__ import annotations

import numpy as np
import pytest
from contact_constants import constants_of
from hypothesis import given
from hypothesis import strategies as st
from stored_energy import bristle_energy_j, skin_energy_j

from frictionloop.physics.bristle_contact import ContactState, bristle_step

K, C, M, DT = 1e3, 1.0, 1e-4, 2e-5
TINY = 1e-300
"""Below this, numbers lose digits."""
LENGTHS_UM = (0.0, 11.5, 30.0)

lengths = st.one_of(st.just(0.0), st.floats(1e-3, 1000.0))
parameters = st.tuples(
    st.floats(1e-6, 1e-3),  # dt
    st.floats(100, 1e4),  # k
    st.floats(0, 10),  # c
    st.floats(1e-5, 1e-3),  # m
    lengths,
)
states = st.builds(ContactState, st.floats(-1e-3, 1e-3), st.floats(-1, 1), st.floats(-2, 2))
limits = st.floats(1e-6, 2)
speeds = st.floats(-1, 1)


def within(state, limit, constants):
    """Return the state once the step has let go of what is too far beyond the limit, which only takes energy."""
    most = limit + constants.beyond
    return state._replace(force_n=min(max(state.force_n, -most), most))


@given(parameters, states, limits, speeds)
def test_a_step_never_gives_energy(values, state, limit, speed):
    """Whatever the parameters, the step, the state (also beyond the limit) and the speed."""
    constants = constants_of(*values)
    state = within(state, limit, constants)
    after, force = bristle_step(state, limit, speed, constants)
    way = constants.dt * speed - (after[0] - state[0])
    before_j, after_j = (bristle_energy_j(each, limit, constants.length) for each in (state[2], after[2]))
    ways = abs(constants.dt * speed) + abs(constants.dt * state[1]) + abs(state[0]) + abs(after[0])
    # The force is known to a share of what it comes from: forces that cancel, ways over what the tip yields.
    forces = abs(force) + abs(state[2]) + ways / constants.yielding
    slack = 1e-14 * (forces * (ways + constants.yielding * abs(state[2])) + before_j + after_j)
    assert force * way - (after_j - before_j) >= -slack - TINY


@given(parameters, states, limits)
def test_a_bone_at_rest_leaves_energy_to_die(values, state, limit):
    """With w = 0 the energy of skin and bristle never grows."""
    constants = constants_of(*values)
    _, k, _, m, _ = values
    state = within(state, limit, constants)

    def energy(state):
        return skin_energy_j(state[0], state[1], k, m) + bristle_energy_j(state[2], limit, constants.length)

    for _ in range(10):
        before = energy(state)
        state = ContactState(*bristle_step(state, limit, 0.0, constants)[0])
        assert energy(state) <= before * (1 + 1e-11) + 1e-24  # J, what rounding makes of forces that cancel


@pytest.mark.parametrize("length_um", LENGTHS_UM)
@given(st.floats(0.05, 1), st.lists(st.floats(-0.2, 0.2), min_size=2, max_size=6))
def test_a_closed_path_costs_energy(length_um, limit, speeds):
    """The bone repeats a closed path; once the tip does too, a round has cost the hand work."""
    constants = constants_of(DT, K, C, M, length_um)
    state, work, start = ContactState(0.0, 0.0, 0.0), 0.0, ContactState(0.0, 0.0, 0.0)
    for _ in range(6):
        start, work = state, 0.0
        for speed in np.repeat([*speeds, -sum(speeds)], 20):
            after, force = bristle_step(state, limit, speed, constants)
            work += force * (DT * speed - (after[0] - state[0]))
            state = ContactState(*after)
    gained = sum(sign * bristle_energy_j(each[2], limit, constants.length) for sign, each in ((1, state), (-1, start)))
    assert work >= gained - 1e-15


def test_a_slow_round_without_a_length_costs_its_hysteresis_loop():
    """A bone that goes back and forth by 2 X costs 4 Fc (X - Fc/k) in the contact when it is slow."""
    limit, speed, half_way = 0.1, 1e-3, 0.5e-3
    constants, steps = constants_of(DT, K, C, M, 0.0), round(2 * half_way / (speed * DT))
    state, work = ContactState(0.0, 0.0, 0.0), 0.0
    for turn in range(4):
        for _ in range(steps):
            signed = speed if turn % 2 == 0 else -speed
            after, force = bristle_step(state, limit, signed, constants)
            if turn >= 2:
                work += force * (DT * signed - (after[0] - state[0]))
            state = ContactState(*after)
    # The damper's force c w moves the corners of the loop by c w/k at most.
    assert work == pytest.approx(4 * limit * (half_way - limit / K), abs=4 * limit * C * speed / K)
