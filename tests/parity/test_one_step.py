"""One step of each law from the same state and the same quantised input: the C core against the float64 step."""

from __future__ import annotations

import numpy as np
import pytest
from held_sections import FREE, HELD, section
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.filtered_pi import filtered_pi_gains
from frictionloop.control.pi import PiGains, PiState, pi_step
from frictionloop.sensing.measurement import Measurement

ONE, FULL = 2.0**28, 2**30
"""1 N in words, and 4 N: differences of two forces stay within a word."""
FORCE_N = 2e-4
"""Allowed difference of the force command."""
SYNTHESISED = (
    (0.316056, -0.621038, 0.313840, -0.157528, 0.093406),
    (0.824763, 0.589836, -0.234950, 0.518335, -0.003914),
    (1.006910, -1.995416, 0.988711, -1.995449, 0.995615),
    (1.361505, -0.035465, 0.000785, -0.854825, 0.453190),
    (0.997675, -1.994059, 0.996384, -1.994046, 0.994049),
    (1.145830, -1.896392, 0.756322, -1.961558, 0.961808),
)
"""What an H-infinity synthesis for the bench asks for (`design_hinf`, to six places)."""
UNHELD = (section([1.2, 0.5], [0.99 + 0.1j, 0.99 - 0.1j], 0.1), section([0.3, 0.2], [0.9995, 0.2], 0.005)) * 2
MODEL = fl.bench().controller.model
AHEAD = {"feedforward": True, "model": MODEL}
CONTROLLERS = {
    "pi as printed": fl.bench().controller,
    "pi retuned": fl.PiController(kp=0.062, ki=134.0, model=MODEL),
    "lookup": fl.LookupController(model=MODEL),
    "filtered pi, no section": fl.FilteredPiController(model=MODEL),
    "notch": fl.NotchPiController(delay_s=200e-6, **AHEAD),
    "notch, overdriven": fl.NotchPiController(delay_s=330e-6, overdrive=True, **AHEAD),
    "free sections": fl.FilteredPiController(sections=FREE, kp=0.3, delay_s=600e-6, **AHEAD),
    "held sections": fl.FilteredPiController(sections=(*FREE, *HELD), kp=0.4, ki=60.0, **AHEAD),
    "synthesised": fl.FilteredPiController(sections=SYNTHESISED, kp=12.8, ki=531.0, delay_s=200e-6, model=MODEL),
    "sections that cannot be held": fl.FilteredPiController(sections=UNHELD, kp=0.01, ki=5.0, model=MODEL),
}


STEPS = 4
"""Allowed difference of a next state, in steps of its own binary places: sums of at most six rounded products."""


def check(parity, controller, inputs):
    difference, commands, states = parity.one_step(controller, inputs)
    assert np.max(np.abs(difference)) < FORCE_N
    scale = parity.FixedLaw(controller).scale
    # Held sections and the integral take the rounding of the command along, times what holds them.
    allowed = STEPS / scale
    if controller.kind == "filtered_pi":
        allowed[:13] += 2.0 * STEPS * filtered_pi_gains(controller).hold / scale[0]
    apart = np.abs(states) > allowed
    if not getattr(controller, "feedforward", False):
        apart[:, 13:] = False  # the C core does not compute an expected reading that nobody reads
    assert not np.any(apart[:, 1:])
    # Where v is at the clamp to a rounding, the forms may differ on whether the integral goes on; this is rare.
    model = controller.model
    limit = np.minimum(np.abs(commands - model.floor_n), np.abs(commands - model.nominal_n)) < 1e-6
    assert not np.any(apart[:, 0] & ~limit)
    assert np.mean(apart[:, 0]) < 1e-3


@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_and_states_agree(parity, name):
    check(parity, CONTROLLERS[name], parity.wild(20_000, 1))
    check(parity, CONTROLLERS[name], parity.realistic(20_000, 2))


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_and_states_agree_a_million_times(parity, name):
    check(parity, CONTROLLERS[name], parity.wild(500_000, 3))
    check(parity, CONTROLLERS[name], parity.realistic(500_000, 4))


EDGE = st.one_of(st.sampled_from([-FULL, -1, 0, 1, FULL - 1]), st.integers(-FULL, FULL - 1))


@given(
    kp=st.floats(0, 1e6), ki=st.floats(0, 4000), integral=EDGE, force=EDGE, setpoint=EDGE, valid=st.integers(0, 1),
    nominal=st.floats(1e-3, 1.5),
)  # fmt: skip
def test_pi_agrees_for_any_gains_and_any_word(parity, kp, ki, integral, force, setpoint, valid, nominal):
    controller = fl.PiController(kp=kp, ki=ki, model=MODEL.model_copy(update={"nominal_n": nominal}))
    fixed = parity.FixedLaw(controller)
    after, out = fixed.each(words([[integral]]), words([[force, 0, 0, 0, valid]]), words([setpoint]))
    told = Measurement(force / ONE, 0.0, 0.0, 0.0, float(valid))
    gains = PiGains(kp, ki, controller.model.floor_n, nominal)
    state, command = pi_step(PiState(integral / ONE), told, setpoint / ONE, gains, 2e-4)
    assert abs(out[0, 0] / ONE - command.u) < FORCE_N
    # The integral moves as in float64, saturated, or not at all where v is at the clamp to a rounding.
    ideal = max(min(state.integral * ONE, FULL - 1), -FULL)
    assert abs(after[0, 0] - ideal) <= 8 * STEPS or at_the_clamp(kp, integral, force, setpoint, gains)


def at_the_clamp(kp, integral, force, setpoint, gains):
    v = kp * (setpoint - force) / ONE + integral / ONE
    return min(abs(v - gains.low), abs(v - gains.high)) < 1e-8 * max(1.0, abs(v))


def words(numbers):
    return np.array(numbers, dtype=np.int32)


@given(force=EDGE, setpoint=EDGE)
def test_lookup_law_is_the_clamp(parity, force, setpoint):
    fixed = parity.FixedLaw(CONTROLLERS["lookup"])
    _, out = fixed.each(words([[0]]), words([[force, 0, 0, 0, 1]]), words([setpoint]))
    assert out[0, 0] / ONE == pytest.approx(np.clip(setpoint / ONE, MODEL.floor_n, MODEL.nominal_n), abs=1 / ONE)
    assert bool(out[0, 1]) == (out[0, 0] != setpoint)
