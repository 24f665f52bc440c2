"""The limit observer: its contact and loop gain against closed form, and what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.laws import law_of
from frictionloop.control.limit_observer import believed, limit_observer_gains, limit_observer_start, limit_rows
from frictionloop.control.limit_observer_step import LimitState, limit_observer_step
from frictionloop.sensing.measurement import Measurement

BENCH = fl.bench().evolve({"controller.kind": "limit_observer"})
MODEL = BENCH.controller.model


@given(st.floats(0.1, 50.0), st.floats(0.02, 0.15))
def test_the_contact_follows_as_an_implicit_step_of_its_equation(slip_um, speed):
    """f' = (L - f)/T with L and f at the end of the period: off from the exponential by less than x^2/2."""
    controller = BENCH.evolve({"controller.slip_length_um": slip_um}).controller
    gains = limit_observer_gains(controller)
    rests = limit_observer_start(controller)._replace(limit=0.0, friction=0.5, spring=0.5, reading=0.5, forward=1.0)
    after, _ = limit_observer_step(rests, Measurement(0.5, 0.0, speed, 0.5, 1.0), 1.5, gains, 2e-4)
    periods = speed * 200.0 / slip_um
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


@pytest.mark.parametrize("length_um", [11.5, 0.0])
@pytest.mark.parametrize("speed_mm_s", [20.0, 80.0])
def test_the_command_moves_little_from_tick_to_tick(speed_mm_s, length_um):
    """At most 0.3 um rms, an eighth of the largest amplitude (chosen): the plate is driven by little steps."""
    command = replayed(BENCH.evolve({"motion.speed_mm_s": speed_mm_s, "finger.slip_length_um": length_um}), 3.0).command
    assert np.sqrt(np.mean(np.diff(command[5000:]) ** 2)) < 0.3


def test_a_finger_that_needs_much_vibration_gets_what_is_asked():
    """a = (ln(1.4/0.25)/0.35)^1/2 = 2.2 um: believed with twice the model's tau the limit is 2^3.3 N without it."""
    finger = {"friction.nominal_n": 1.4, "friction.susceptibility_per_um2": 0.35, "friction.moist_loss": 0.0}
    held = {"setpoint": fl.Constant(offset_n=0.25), "finger.slip_length_um": 0.0}
    run = fl.simulate(BENCH.evolve({**finger, **held}), 3.0)
    assert float(run["f_a"][10_000:].mean()) == pytest.approx(0.25, rel=0.03)


@pytest.mark.parametrize("force_n", [0.4, 0.8])
@pytest.mark.parametrize("margin", [1.0, 2.0])
def test_the_loop_gain_is_the_fingers_susceptibility_over_the_believed_one(margin, force_n):
    """At every force: a finger twice as susceptible has under a margin of two the loop of the model under one."""
    frequency_hz, tau = np.geomspace(1.0, 2400.0, 40), MODEL.susceptibility_per_um2
    loops = [
        fl.linearise(BENCH.evolve({**slider, "controller.susceptibility_margin": by}), force_n=force).responses(
            frequency_hz
        )["G"]
        for by, force, slider in (
            (1.0, 0.6, {"finger.slip_length_um": 0.0}),
            (margin, force_n, {"finger.slip_length_um": 0.0, "friction.susceptibility_per_um2": margin * tau}),
        )
    ]
    assert loops[1] == pytest.approx(loops[0], rel=1e-4)


def test_it_has_no_more_gains_and_states_than_it_says():
    assert len(limit_observer_start(BENCH.controller)) <= 8
    assert len(limit_observer_gains(BENCH.controller)) - 2 <= 23


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"controller.delay_s": 3e-4}, "delay_s = 0.0003 s: .*0.0002 s"),
        ({"controller.susceptibility_margin": 0.0}, "susceptibility_margin"),
        ({"controller.spring_noise": 0.0}, "spring_noise"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(changed, said):
    with pytest.raises(fl.FrictionloopError, match=said):
        BENCH.evolve(changed)
