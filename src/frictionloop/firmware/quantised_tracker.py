"""The tracker in the firmware's numbers: gains in the order of firmware/core/law_tracker.c, formats of fl_tracker.h."""

from __future__ import annotations

from typing import Any

from frictionloop.control.tracker import SMOOTH
from frictionloop.control.tracker_gains import tracker_gains
from frictionloop.control.tracker_state import SensorStep, TrackerGains, TrackerState
from frictionloop.firmware.quantised import Gain, to_fixed, to_gain, to_places, to_row
from frictionloop.parameters.tracking import Schedule
from frictionloop.quantities import FrictionloopError

CORRECTING, SHARING = 24, 28
"""Binary places of gains on an innovation, and of the schedule's last columns, which are shares."""
PLACES = dict.fromkeys(TrackerState._fields, 28) | {
    "limit": 26, "trusted": 26, "load": 26, "spring": 23, "rate": 22, "reading": 24, "forward": 0,
    "rising": 15, "falling": 15, "quick": 15, "compliance": 20, "power_c": 60, "power_t": 52,
    "by_c0": 30, "by_c1": 30, "by_c2": 31, "by_c3": 30, "by_c4": 32,
    "by_t0": 26, "by_t1": 26, "by_t2": 27, "by_t3": 26, "by_t4": 28,
}  # fmt: skip
"""Of the states; the mean squares are in two words, the lower ones behind all others."""
WIDE = ("power_c", "power_t")
TRACKER_PLACES = (
    *(PLACES[name] - 32 * (name in WIDE) for name in TrackerState._fields),
    *(PLACES[name] for name in WIDE),
)
PLACES_OF_A_ROW = (*[CORRECTING] * 5, SHARING, SHARING)
"""Of the schedule."""
LARGEST_OVER_LEAST = 10.0
"""1 over the least force, in N, by which the tracker divides what one reading may move the limit."""
LEAST_LEAD = 2.0**-8
"""Least share of the error to correct in a period."""
_IN = {"1": 1, "2": 0, "3": 2, "b": 0, "c": 0}
"""Places of spring, rate, reading and the two frictions beyond the friction's, alike in all groups (fl_tracker.h)."""
TOO_FAST = 1.2
"""Of the skin's rate, as `tracker_step` limits a rise."""


def tracker_quantised(controller: Any) -> tuple[Gain, ...]:
    """Return the gains of `tracker_step` for its C form.

    Raises
    ------
    FrictionloopError
        When one does not fit: the largest jump must be below 0.8 N, the largest amplitude below 8 um.
    """
    own, sensor, *_ = tracker_gains(controller)
    rate, largest = controller.rate_hz, own.largest_um
    before = {
        "rest": (own.rest, 30), "decay_rest": (own.decay_rest, 30), "decay_left": (own.decay_left, 30),
        "decay": (own.decay, 30), "1/(1 - decay of the believed plate)": (own.inverse, 24),
        "controller.model.max_amplitude_um": (largest, 28), "its square": (largest * largest, 25),
        "controller.largest_compliance_um_per_n": (own.largest_compliance, 20),
    }  # fmt: skip
    after = {
        "controller.load_exponent": (own.load_exponent, 29), "load_gain": (own.load_gain, 30),
        "controller.skin_stiffness_n_m": (own.skin, 12), "rise in a period": (TOO_FAST * own.skin / rate, 20),
        "period in us": (1e6 / rate, 20), "rate of smoothing": (SMOOTH * rate, 20),
        "controller.largest_jump_n": (own.jump, 28), "log2 of controller.model.nominal_n": (own.log2_nominal, 26),
        "tau / ln 2": (own.model_fall, 28),
    } | {name: (getattr(own, name), CORRECTING) for name in TrackerGains._fields[-4:]}  # fmt: skip
    _check(controller)
    return (
        *(to_fixed(value, places, name) for name, (value, places) in before.items()),
        to_gain(own.learn_c, "controller.compliance_learning"),
        to_gain(own.learn_t, "controller.susceptibility_learning"),
        *(to_fixed(value, places, name) for name, (value, places) in after.items()),
        *_sensor(sensor),
        *_rows(controller.schedule),
    )


def _check(controller: Any) -> None:
    """Raise for what fits its word but not what becomes of it."""
    to_places(LARGEST_OVER_LEAST * controller.largest_jump_n, 28, "controller.largest_jump_n over 0.1 N")
    for row in controller.schedule:
        if row[5] < LEAST_LEAD:
            raise FrictionloopError(
                f"controller.schedule: a share of the error of {row[5]:g} must be at least 1/256 to fit the firmware"
            )


def _rows(schedule: Schedule) -> list[Gain]:
    """Return the rows of the schedule, one after another."""
    return [
        to_fixed(value, places, "controller.schedule")
        for row in schedule
        for value, places in zip(row, PLACES_OF_A_ROW, strict=True)
    ]


def _sensor(step: SensorStep) -> list[Gain]:
    rows = {"1": ("a11", "a12", "b1", "c1"), "2": ("a21", "a22", "b2", "c2"), "3": ("a31", "a32", "a33", "b3", "c3")}
    gains = []
    for row, names in rows.items():
        inputs = [_IN[name[-1] if name[0] == "a" else name[0]] for name in names]
        gains += to_row([getattr(step, name) for name in names], inputs, _IN[row], "believed sensor")
    return gains
