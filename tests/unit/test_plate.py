"""The plate's envelope: step and frequency response of a first-order low-pass, and what the drive can do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.physics.plate import limit_step, linearise_plate, lowpass_step

PLATE = fl.paper().plate
OMEGA = 2 * math.pi * PLATE.cutoff_hz


@given(st.floats(0, 2.5), st.floats(0, 2.5), st.lists(st.floats(1e-6, 1e-2), min_size=1, max_size=20))
def test_held_commands_follow_the_exponential_whatever_the_steps(start, command, pieces):
    a = start
    for h in pieces:
        a = lowpass_step(a, command, math.exp(-OMEGA * h))
    exact = command + (start - command) * math.exp(-OMEGA * sum(pieces))
    # Each piece rounds twice at the size of a, and the decay once.
    assert a == pytest.approx(exact, abs=4 * len(pieces) * 2.0**-52 * 2.5)


@given(st.floats(0, 2.5), st.floats(0, 2.5), st.floats(0, 1))
def test_the_amplitude_stays_between_where_it_was_and_the_command(start, command, decay):
    a = lowpass_step(start, command, decay)
    slack = 2.0**-52 * max(start, command)
    assert min(start, command) - slack <= a <= max(start, command) + slack


def test_the_drive_is_limited():
    for command, limited in [(-1.0, 0.0), (0.0, 0.0), (1.3, 1.3), (2.5, 2.5), (3.0, 2.5), (math.inf, 2.5)]:
        assert limit_step(command, 2.5) == limited


def test_a_held_command_through_the_simulator():
    """With kp = ki = 0 the command is a_max from the first sample: a(t) = a_max (1 - e^(-wc t))."""
    system = fl.paper().evolve({"controller.kp": 0.0, "controller.ki": 0.0})
    run = fl.simulate(system, 0.1)
    exact = -2.5 * np.expm1(-OMEGA * run["time"].values)
    # 500 periods, each rounding a few times at the size of 2.5 um, less what the pole forgets: below 1e-14.
    np.testing.assert_allclose(run["a"].values, exact, rtol=0, atol=1e-14)


def test_frequency_response():
    plate = linearise_plate(PLATE)
    assert plate.response(0.0) == 1.0
    assert abs(plate.response(100.0)) == pytest.approx(math.sqrt(0.5), rel=1e-14)
    assert np.angle(plate.response(100.0)) == pytest.approx(-math.pi / 4, rel=1e-14)
    assert abs(plate.response(1e6)) == pytest.approx(1e-4, rel=1e-7)  # -20 dB per decade
