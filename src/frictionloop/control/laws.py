"""Every control law by the number that the kernels know it by; 0 is a caller who commands (``Stepper``)."""

from __future__ import annotations

from typing import Any

from frictionloop.control import disturbance_observer, super_twisting, tracker_state
from frictionloop.control.disturbance_observer import disturbance_observer_gains, disturbance_observer_step
from frictionloop.control.filtered_pi import GAINS, STATES, filtered_pi_gains, filtered_pi_start, filtered_pi_step
from frictionloop.control.law import Law
from frictionloop.control.observer_gains import observer_start
from frictionloop.control.open_loop import open_loop_step
from frictionloop.control.pi import pi_step
from frictionloop.control.super_twisting import super_twisting_gains, super_twisting_start, super_twisting_step
from frictionloop.control.switch import filtered_pi_begin, pi_begin, tracker_follow
from frictionloop.control.tracker import tracker_step
from frictionloop.control.tracker_gains import tracker_gains, tracker_start
from frictionloop.quantities import FrictionloopError

LAWS = (
    Law("pi", pi_step, states=1, gains_of=lambda c: (c.kp, c.ki), gains=2, begin=pi_begin),
    Law("lookup", open_loop_step, states=1, gains_of=lambda c: (), gains=0),
    Law(
        "filtered_pi", filtered_pi_step, STATES, filtered_pi_gains, GAINS, filtered_pi_start, begin=filtered_pi_begin,
    ),
    Law(
        "observer", disturbance_observer_step, states=disturbance_observer.STATES, gains=disturbance_observer.GAINS,
        gains_of=disturbance_observer_gains, start_of=observer_start,
    ),
    Law(
        "super_twisting", super_twisting_step, states=super_twisting.STATES, gains=super_twisting.GAINS,
        gains_of=super_twisting_gains, start_of=super_twisting_start,
    ),
    Law(
        "tracker", tracker_step, states=tracker_state.STATES, gains=tracker_state.GAINS, gains_of=tracker_gains,
        start_of=tracker_start, frozen=tracker_state.ESTIMATES, follow=tracker_follow,
    ),
)  # fmt: skip
"""The first is number 1."""
SAME_STEP = {"notch_pi": "filtered_pi"}
"""Kinds of parameters that run with the law of another kind."""


def law_of(controller: Any) -> Law:
    """Return the law that a controller's parameters are for."""
    return LAWS[law_number(controller) - 1]


def law_number(controller: Any) -> int:
    """Return the number of that law."""
    kinds = [law.kind for law in LAWS]
    if (kind := SAME_STEP.get(controller.kind, controller.kind)) not in kinds:
        accepted = ", ".join([*kinds, *SAME_STEP])
        raise FrictionloopError(f"controller.kind = {kind!r}: is no control law, but must be one of {accepted}")
    return 1 + kinds.index(kind)
