"""Sections that the command holds: against a transfer function in scipy, their bounds, and no kick of old errors."""

from __future__ import annotations

import numpy as np
import pytest
from held_sections import FREE, HELD, section
from hypothesis import given, settings
from hypothesis import strategies as st
from run_filtered import CLAMP, RATE, TOLD, columns, run
from scipy import signal

import frictionloop as fl
from frictionloop.control.filtered_pi import filtered_pi_gains, hold_gain

KP, KI = 0.4, 60.0
THROUGH = (1.0, 0.0, 0.0, 0.0, 0.0)

INVERSES = [np.sum(np.abs(signal.lfilter([1.0, *s[3:]], s[:3], np.eye(1, 40000)[0]))) for s in HELD]
"""Largest output of each one's inverse for an input of at most 1."""


def law(held, **changes):
    return fl.FilteredPiController(kp=KP, ki=KI, sections=(*FREE, *held), **changes)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_held_sections_are_hanus_on_a_state_space(count):
    """x+ = A x + B (e + (u - v)/D), v = C x + D e: sections and PI as one, in a realisation of another kind."""
    error = np.cumsum(np.random.default_rng(count).standard_normal(1500)) / 40.0
    got, _ = run(law(HELD[:count]), np.full(1500, 0.5), 0.5 - error)
    A, B, C, D = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1))
    for b, a in [*((s[:3], [1.0, *s[3:]]) for s in HELD[:count]), ([KP, KI / RATE - KP], [1.0, -1.0])]:
        a2, b2, c2, d2 = signal.tf2ss(b, a)
        A, B = np.block([[A, np.zeros((len(A), len(a2)))], [b2 @ C, a2]]), np.vstack([B, b2 @ D])
        C, D = np.hstack([d2 @ C, c2]), d2 @ D
    x, wanted = np.zeros((len(A), 1)), []
    for e in signal.sosfilt([[*s[:3], 1.0, *s[3:]] for s in FREE], error):
        v = C @ x + D * e
        u = np.clip(v, *CLAMP)
        x = A @ x + B @ (e + (u - v) / D)
        wanted.append(u[0, 0])
    np.testing.assert_allclose(got[:, 0], wanted, rtol=0, atol=1e-9)
    assert 0.1 < got[:, 1].mean() < 0.95


@settings(max_examples=60)
@given(
    TOLD,
    st.integers(1, 4),
    st.booleans(),
)
def test_nothing_winds_up_whatever_the_error(told, count, feedforward):
    """kp y + I is the command, so I moves towards it by ki dt/kp of the way, and never beyond."""
    forces, setpoints, valid = columns(told)
    controller = law(HELD[:count], feedforward=feedforward, overdrive=feedforward)
    assert filtered_pi_gains(controller).hold != 0.0
    got, states = run(controller, setpoints, forces, valid)
    assert np.all((got[:, 0] >= CLAMP[0]) & (got[:, 0] <= CLAMP[1]))
    ahead = setpoints if feedforward else np.zeros(1)
    assert np.max(states[:, 0]) <= max(0.0, CLAMP[1] - ahead.min()) + 1e-9
    assert np.min(states[:, 0]) >= min(0.0, CLAMP[0] - ahead.max()) - 1e-9
    # A held section has the output that leads to the command, and the input that its inverse makes of that.
    y = (np.ptp(np.append(ahead, 0.0)) + CLAMP[1]) / KP
    for i in reversed(range(count)):
        b0, _, b2, _, a2 = HELD[i]
        x = y * INVERSES[i]
        assert np.max(np.abs(states[:, 5 + 2 * i])) <= (y + abs(b0) * x) * (1 + 1e-9)
        assert np.max(np.abs(states[:, 6 + 2 * i])) <= (abs(a2) * y + abs(b2) * x) * (1 + 1e-9)
        y = x


@pytest.mark.parametrize("feedforward", [False, True])
@pytest.mark.parametrize("gap", [1, 40, 400])
def test_a_long_memory_does_not_kick_after_an_invalid_stretch(gap, feedforward):
    """1 N of error for 60 ms, as of a skin that stretches, then no sliding, then no error: u goes on from I."""
    steps = 300 + gap + 1000

    def kick(sections):
        controller = fl.FilteredPiController(kp=KP, ki=KI, sections=sections, feedforward=feedforward)
        valid, error, setpoint = np.ones(steps), np.zeros(steps), np.full(steps, 0.5)
        valid[300 : 300 + gap], error[:300] = 0.0, -1.0
        # The expected reading follows from set-point and clamp alone.
        _, states = run(controller, setpoint, setpoint, valid)
        reading = np.concatenate([[0.8], states[:-1, 20]]) if feedforward else setpoint
        got, states = run(controller, setpoint, reading - error, valid)
        assert got[30:300, 1].all()  # the clamp acted
        rest = np.clip(states[300 + gap - 1, 0] + 0.5 * feedforward, *CLAMP)
        return np.abs(got[300 + gap :, 0] - rest)

    slow = (HELD[1], HELD[0])
    held = kick((THROUGH, THROUGH, *slow))
    assert held[0] < 1e-3
    assert held.max() < 0.06
    # The same sections left free remember the error for longer than that.
    assert kick(slow).max() > 0.1


@pytest.mark.parametrize(
    ("kp", "ki", "held", "wanted"),
    [
        (0.5, 50.0, (), 0.0),
        (0.5, 50.0, (section([0.5, 0.2], [0.9, 0.9], 0.25),), 8.0),
        (0.5, 50.0, (section([1.01, 0.2], [0.9, 0.9]),), 0.0),
        (0.5, 50.0, (section([-1.0, 0.2], [0.9, 0.9]),), 0.0),
        (0.5, 50.0, ((0.0, 0.5, 0.1, -0.5, 0.0),), 0.0),
        (0.5, 2501.0, (section([0.5, 0.2], [0.9, 0.9]),), 0.0),
        (0.0, 0.0, (section([0.5, 0.2], [0.9, 0.9]),), 0.0),
    ],
)
def test_only_what_can_be_inverted_is_held(kp, ki, held, wanted):
    assert hold_gain(kp, ki, (*FREE, *held), 1.0 / RATE) == pytest.approx(wanted, rel=1e-12)
