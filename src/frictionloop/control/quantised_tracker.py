"""The tracker in the firmware's numbers: gains in the order of firmware/core/law_tracker.c, formats of fl_tracker.h."""

from __future__ import annotations

from typing import Any

from frictionloop.control.quantised import Gain, to_gain
from frictionloop.control.quantised_rows import to_fixed, to_row
from frictionloop.control.tracker import SMOOTH
from frictionloop.control.tracker_gains import tracker_gains
from frictionloop.control.tracker_state import SCHEDULED, SensorStep, TrackerGains, TrackerState
from frictionloop.parameters.tracking import SHARES

LIMIT, SHARE, COMPLIANCE, CORRECTING, SQUARE = 26, 28, 20, 24, 25
"""Binary places of logarithms and limits, shares and forces, um/N, gains on an innovation, and um^2."""
PLACES = dict.fromkeys(TrackerState._fields, 28) | {
    "limit": LIMIT, "trusted": LIMIT, "load": LIMIT, "spring": 23, "rate": 22, "reading": 24, "forward": 0,
    "rising": 15, "compliance": COMPLIANCE, "power_c": 60, "power_t": 52,
    "by_c0": 30, "by_c1": 30, "by_c2": 31, "by_c3": 30, "by_c4": 32,
    "by_t0": 26, "by_t1": 26, "by_t2": 27, "by_t3": 26, "by_t4": 28,
}  # fmt: skip
"""Of the states; the mean squares are in two words, the lower ones behind all others."""
WIDE = ("power_c", "power_t")
TRACKER_PLACES = (
    *(PLACES[name] - 32 * (name in WIDE) for name in TrackerState._fields),
    *(PLACES[name] for name in WIDE),
)
_IN = {"1": 1, "2": 0, "3": 2, "b": 0, "c": 0}
"""Places of spring, rate, reading and the two frictions beyond the friction's, alike in all groups (fl_tracker.h)."""
_TOO_FAST = 1.2
"""Of the skin's rate, as `tracker_step` limits a rise."""


def tracker_quantised(controller: Any) -> tuple[Gain, ...]:
    """Return the gains of `tracker_step` for its C form.

    Raises
    ------
    FrictionloopError
        When one does not fit: the largest jump must be below 8 N, the largest amplitude below 8 um.
    """
    gains = tracker_gains(controller)
    own = TrackerGains(*gains[: len(TrackerGains._fields)])
    rest = gains[len(TrackerGains._fields) :]
    sensor, slopes = SensorStep(*rest[: len(SensorStep._fields)]), rest[len(SensorStep._fields) :]
    names = ("rest", "decay_rest", "decay_left", "decay", "inverse", "learn_c", "learn_t", "load_exponent", "load_gain")
    rate = controller.rate_hz
    steep = {
        "model_fall": own.model_fall,
        "fastest": own.skin,
        "largest rise": _TOO_FAST * own.skin / rate,
        "way": 1e6 / rate,
        "smooth rate": SMOOTH * rate,
    }
    fixed = {
        "controller.model.max_amplitude_um": (own.largest_um, 28),
        "controller.model.max_amplitude_um^2": (own.largest_um**2, SQUARE),
        "controller.largest_compliance_um_per_n": (own.largest_compliance, COMPLIANCE),
        "controller.largest_jump_n": (own.jump, 28),
        "log2 of controller.model.nominal_n": (own.log2_nominal, LIMIT),
    } | {name: (getattr(own, name), CORRECTING) for name in TrackerGains._fields[-4:]}
    columns = [slopes[i : i + len(SHARES)] for i in range(0, SCHEDULED * len(SHARES), len(SHARES))]
    return (
        *(to_gain(getattr(own, name), name) for name in names),
        *(to_gain(value, name) for name, value in steep.items()),
        *(to_fixed(value, places, name) for name, (value, places) in fixed.items()),
        *_sensor(sensor),
        *(gain for column in columns for gain in to_row(column, [0] * len(SHARES), 0, "controller.schedule")),
    )


def _sensor(step: SensorStep) -> list[Gain]:
    rows = {"1": ("a11", "a12", "b1", "c1"), "2": ("a21", "a22", "b2", "c2"), "3": ("a31", "a32", "a33", "b3", "c3")}
    gains = []
    for row, names in rows.items():
        inputs = [_IN[name[-1] if name[0] == "a" else name[0]] for name in names]
        gains += to_row([getattr(step, name) for name in names], inputs, _IN[row], "believed sensor")
    return gains
