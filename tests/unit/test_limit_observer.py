"""The limit observer: its contact against closed form, what it learns and what not, and what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.laws import law_of
from frictionloop.control.limit_gains import believed, limit_rows
from frictionloop.control.limit_observer import limit_observer_gains, limit_observer_start
from frictionloop.control.limit_step import STATED, LimitState, learnt_step, limit_observer_step
from frictionloop.sensing.measurement import Measurement

BENCH = fl.bench().evolve({"controller.kind": "limit_observer"})
MODEL = BENCH.controller.model


@given(st.floats(0.1, 50.0), st.floats(0.02, 0.15))
def test_the_contact_follows_as_an_implicit_step_of_its_equation(compliance, speed):
    """f' = (L - f)/T with L and f at the end of the period: off from the exponential by less than x^2/2."""
    told = {"controller.compliance_um_per_n": compliance, "controller.skin_stiffness_n_m": 1e9}
    controller = BENCH.evolve(told).controller
    gains = limit_observer_gains(controller)
    rests = limit_observer_start(controller)._replace(limit=0.0, friction=0.5, spring=0.5, reading=0.5, forward=1.0)
    after, _ = limit_observer_step(rests, Measurement(0.5, 0.0, speed, 0.5, 1.0), 1.5, gains, 2e-4)
    periods = speed * 200.0 / (0.5 * compliance)
    moved = (after.friction - 0.5) / 0.5
    assert moved == pytest.approx(1.0 - 1.0 / (1.0 + periods), rel=1e-9)
    assert abs(moved + math.expm1(-periods)) < min(periods**2 / 2.0, 0.21)


def test_gains_of_a_slider_are_those_of_a_contact_that_hardly_lags():
    (quick, _), rates = limit_rows(MODEL, 5000.0, 80000.0, 0.5), believed(MODEL, 5000.0, 0.0)
    assert quick[0] == quick[1]
    assert rates.shape == (4, 4)
    # Without vibration and with the limit known, a force of 1 is read as 1.
    at_rest = np.linalg.solve(rates[1:, 1:], -rates[1:, 0])
    assert at_rest == pytest.approx([1.0, 0.0, 1.0], abs=1e-12)


@given(st.floats(0.05, 5.0), st.floats(-3, 3), st.floats(-3, 3), st.floats(0.006, 9.0), st.floats(1.0, 10.0))
def test_what_is_learnt_keeps_to_its_bounds(fall, z, h, swing, spread):
    model = 0.55
    new = learnt_step(fall, z, h, swing, 1e-3, spread, model)
    assert model / spread * (1 - 1e-12) <= new <= model * spread * (1 + 1e-12)


def test_too_much_susceptibility_is_lowered_and_too_little_raised():
    """A limit that seems to fall as the set-point rises is one whose vibration does less than believed."""
    assert learnt_step(0.5, 0.3, -0.1, 0.05, 1e-3, 2.0, 0.5) < 0.5
    assert learnt_step(0.5, 0.3, 0.1, 0.05, 1e-3, 2.0, 0.5) > 0.5


def replayed(system, duration_s):
    """What the law knows after each tick of a run, as rows: it goes along with the plant, tick by tick."""
    law, gains = law_of(system.controller), limit_observer_gains(system.controller)
    state, states = limit_observer_start(system.controller), []
    run = fl.simulate(system, duration_s)
    for force, speed, valid, wanted in zip(
        *(run[name].values for name in ("f_m", "speed", "sliding", "f_r")), strict=True
    ):
        state, _ = law.step(state, Measurement(force, 0.0, speed, 0.5, float(valid)), wanted, gains, 2e-4)
        states.append(state)
    return LimitState(*np.array(states).T)


def believed_tau(system, duration_s):
    return replayed(system, duration_s).fall[-1] * math.log(2.0)


@pytest.mark.parametrize("length_um", [11.5, 0.0])
@pytest.mark.parametrize("speed_mm_s", [20.0, 80.0])
def test_the_command_moves_little_from_tick_to_tick(speed_mm_s, length_um):
    """At most 0.3 um rms, an eighth of the largest amplitude (chosen): the plate is driven by little steps."""
    told = {"controller.compliance_um_per_n": 50.0 if length_um else 0.0}
    command = replayed(
        BENCH.evolve({"motion.speed_mm_s": speed_mm_s, "finger.slip_length_um": length_um, **told}), 3.0
    ).command
    assert np.sqrt(np.mean(np.diff(command[5000:]) ** 2)) < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("length_um", [11.5, 0.0])
@pytest.mark.parametrize("tau", [0.3, 0.6])
def test_a_moving_set_point_teaches_the_susceptibility(tau, length_um):
    """Four times T_l, from the upper bound, to what friction noise leaves unsure."""
    finger = {"friction.susceptibility_per_um2": tau, "friction.moist_loss": 0.0, "finger.slip_length_um": length_um}
    told = {"controller.compliance_um_per_n": 50.0 if length_um else 0.0}
    assert believed_tau(BENCH.evolve({**finger, **told}), 12.0) == pytest.approx(tau, rel=0.15)


def test_a_set_point_that_rests_teaches_nothing():
    held = BENCH.evolve({"setpoint": fl.Constant(offset_n=0.6)})
    upper = BENCH.controller.susceptibility_spread * MODEL.susceptibility_per_um2
    assert believed_tau(held, 2.0) == pytest.approx(upper, rel=1e-12)


def test_a_finger_that_needs_much_vibration_gets_what_is_asked():
    """a = (ln(1.4/0.25)/0.35)^1/2 = 2.2 um: believed with three times the model's tau the limit is 2^6 N without it."""
    finger = {"friction.nominal_n": 1.4, "friction.susceptibility_per_um2": 0.35, "friction.moist_loss": 0.0}
    held = {"setpoint": fl.Constant(offset_n=0.25), "finger.slip_length_um": 0.0, "controller.compliance_um_per_n": 0.0}
    run = fl.simulate(BENCH.evolve({**finger, **held}), 3.0)
    assert float(run["f_a"][10_000:].mean()) == pytest.approx(0.25, rel=0.03)


def test_with_a_spread_of_one_nothing_is_learnt():
    told = BENCH.evolve({"controller.susceptibility_spread": 1.0})
    assert believed_tau(told, 2.0) == pytest.approx(MODEL.susceptibility_per_um2, rel=1e-12)


def test_what_readings_move_by_more_than_is_stated_ends_learning():
    """Innovations of 1 N at every reading, of a finger of 0.5 N: after a while phi is where it began."""
    gains, start = limit_observer_gains(BENCH.controller), limit_observer_start(BENCH.controller)
    state = start._replace(fall=gains.model_fall, limit=0.0, friction=0.5, spring=0.5, reading=0.5, forward=1.0)
    for k in range(2500):
        state, _ = limit_observer_step(state, Measurement(0.5 + (-1.0) ** k, 0.0, 0.08, 0.5, 1.0), 0.4, gains, 2e-4)
    assert state.misfit > STATED**2
    assert state.fall == pytest.approx(start.fall, rel=1e-12)


def test_it_has_no_more_gains_and_states_than_it_says():
    assert len(limit_observer_start(BENCH.controller)) <= 14
    assert len(limit_observer_gains(BENCH.controller)) - 2 <= 25


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"controller.delay_s": 3e-4}, "at most one control period"),
        ({"controller.susceptibility_spread": 0.5}, "susceptibility_spread"),
        ({"controller.spring_noise": 0.0}, "spring_noise"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(changed, said):
    with pytest.raises(fl.FrictionloopError, match=said):
        BENCH.evolve(changed)


def test_it_needs_a_resonance():
    with pytest.raises(fl.FrictionloopError, match="needs the resonance of the force sensor"):
        limit_observer_gains(BENCH.evolve({"controller.model.resonance_hz": 0.0}).controller)
