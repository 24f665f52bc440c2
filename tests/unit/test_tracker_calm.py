"""A loop that rings calms itself: friction that falls faster than the skin follows changes what is believed."""

from __future__ import annotations

from types import FunctionType

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.tracker import CALM_C, CALM_T, tracker_step
from frictionloop.control.tracker_gains import tracker_gains, tracker_start
from frictionloop.parameters.tracking import TrackerController
from frictionloop.quantities.arithmetic import step
from frictionloop.sensing.measurement import Measurement

DT, SPEED = 1.0 / 5000, 0.02
C = TrackerController(model=fl.bench().controller.model, rate_hz=5000, delay_s=2e-4)
START = tracker_start(C)._replace(compliance=40.0, forward=1.0)
LIMIT_N_S = -2.0 * C.skin_stiffness_n_m * SPEED
"""-40 N/s: steeper than the skin follows, twice over."""
RINGING = {
    "controller.kind": "tracker", "controller.compliance_um_per_n": 50.0, "controller.compliance_learning": 0.0,
    "controller.susceptibility_learning": 0.0, "friction.nominal_n": 0.9, "friction.susceptibility_per_um2": 5 * 0.38,
    "motion.stroke_mm": 240.0, "controller.resonance_share": 0.966, "controller.broadened_q": 2.0,
    "controller.schedule": (
        (15.68, 26.53, 1.798, 9.073, 0.9322, 0.14, 0.6608), (10.49, 17.01, 1.855, 7.243, 0.9975, 0.1426, 0.9148),
        (8.023, 25.39, 2.007, 9.849, 0.9978, 0.2931, 0.9148), (48.82, 46.28, 2.096, 12.84, 0.9762, 1.0, 0.9286),
        (31.41, 30.14, 1.833, 9.7, 0.9303, 1.0, 0.9277), *[(14.0, 14.0, 1.569, 6.559, 0.8844, 1.0, 0.9268)] * 5,
    ),
}  # fmt: skip
"""Five times the effect of vibration that is believed, and nothing that would learn it but the rule.

Gains for Ms 2.0; those for Ms 1.7, which the tracker has by default, hold even then.
"""


def after(state, speed=SPEED, valid=1.0):
    """Return the state after a reading that is just as expected: nothing else moves the estimates."""
    seen = Measurement(state.reading, 0.0, speed, 0.5, valid)
    return tracker_step(state, seen, 0.6, tracker_gains(C), DT)[0]


@pytest.mark.parametrize("speed", [SPEED, -SPEED, 0.08])
@pytest.mark.parametrize("share", [1.01, 3.0])
def test_a_fall_faster_than_the_skin_calms(share, speed):
    """Less lag, more effect of vibration: c (1 - CALM_C) and tau (1 + CALM_T), the steepness by the speed."""
    rising = share * LIMIT_N_S * abs(speed) / SPEED
    found = after(START._replace(rising=rising, forward=np.sign(speed)), speed)
    assert found.compliance == pytest.approx(START.compliance * (1 - CALM_C), rel=1e-12)
    assert found.fall == pytest.approx(START.fall * (1 + CALM_T), rel=1e-12)
    assert 0 < CALM_T <= CALM_C < 0.01  # a few ticks of noise must not undo what is learnt


@pytest.mark.parametrize(("speed", "falling"), [(SPEED, 5.1), (-SPEED, 200.0), (0.08, 20.1), (0.002, 25.5)])
def test_falls_that_are_steep_on_average_take_off_lag_alone(speed, falling):
    """Excess above k v / 4 and 0.05 N m/s^2 / v, though rises make up for it: c (1 - CALM_C), tau as it was."""
    found = after(START._replace(falling=falling, forward=np.sign(speed)), speed)
    assert found.compliance == pytest.approx(START.compliance * (1 - CALM_C), rel=1e-12)
    assert found.fall == START.fall


@pytest.mark.parametrize(
    ("rising", "falling", "valid"),
    [
        (0.99 * LIMIT_N_S, 0.0, 1.0), (0.0, 0.0, 1.0), (-3.0 * LIMIT_N_S, 0.0, 1.0), (3.0 * LIMIT_N_S, 0.0, 0.0),
        (0.0, 4.9, 1.0), (0.0, -3.0 * LIMIT_N_S, 0.0),
    ],
)  # fmt: skip
def test_nothing_else_does(rising, falling, valid):
    """A slower fall, rest, a steep rise, a finger that is not on the plate; slower falls on average."""
    found = after(START._replace(rising=rising, falling=falling), valid=valid)
    assert (found.compliance, found.fall) == (START.compliance, START.fall)


def test_a_slow_finger_in_noise_is_not_taken_for_ringing():
    """At 2 mm/s, where k v is 2 N/s and noise of 0.12 mN in a gain of 40 makes an excess of some 12 N/s by itself."""
    assert after(START._replace(falling=24.5), 0.002).compliance == START.compliance


@pytest.mark.parametrize("compliance", [20.0, 5.0])
def test_steep_falls_on_average_leave_a_compliance_from_which_either_contact_is_found(compliance):
    start = START._replace(compliance=compliance)
    assert after(start._replace(falling=200.0)).compliance == compliance
    assert after(start._replace(rising=3.0 * LIMIT_N_S)).compliance < compliance


def test_the_bounds_hold():
    """Ringing for ever leaves the susceptibility at 3 um^-2 (as ``fall``) and the compliance above 0."""
    state = START._replace(fall=2.9999, compliance=1e-3)
    for _ in range(5):
        state = after(state._replace(rising=3.0 * LIMIT_N_S))
    assert state.fall == 3.0 and 0.0 < state.compliance < 1e-3


def without_the_rule():
    """Return the law compiled anew from its own code, but ringing changes nothing."""
    law = tracker_step.py_func
    return step(FunctionType(law.__code__, {**law.__globals__, "CALM_C": 0.0, "CALM_T": 0.0}, law.__name__))


def last_second_n(law, system):
    """Run a law on the bench's plant for 2 s; return the rms of the second one."""
    c, plant = system.controller, fl.Stepper(system)
    gains, state = tracker_gains(c), tracker_start(c)
    errors = []
    for _ in range(10000):
        state, _ = law(state, plant.measured, 0.6, gains, DT)
        plant.tick(state.command)
        errors.append(plant.force_n - 0.6)
    return float(np.sqrt(np.mean(np.square(errors[5000:]))))


def test_a_ringing_loop_calms_down():
    """Below 40 mN in the last of two seconds, and more than twice that without the rule."""
    system = fl.bench().evolve(RINGING)
    assert last_second_n(tracker_step, system) < 0.04
    assert last_second_n(without_the_rule(), system) > 0.08


def test_it_calms_down_in_the_simulator():
    run = fl.simulate(fl.bench().evolve({**RINGING, "setpoint": fl.Constant(offset_n=0.6)}), duration_s=2.0, seed=0)
    error = (run["f_a"] - run["f_r"]).values[run["time"].values > 1.0]
    assert np.sqrt(np.mean(error**2)) < 0.04
