"""The limit observer in the firmware's numbers: gains in the order and formats of core/law_limit_observer.c."""

from __future__ import annotations

from typing import Any

from frictionloop.control.limit_observer import limit_observer_gains
from frictionloop.control.limit_step import LARGEST_LOG2
from frictionloop.firmware.quantised import ROW, Gain, to_fixed, to_places

LIMIT_PLACES = (28, 28, 26, 28, 24, 24, 24, 0)
CORRECTING = 24
"""Binary places of gains on an innovation; of what they have more per period of T, 28."""


def limit_observer_quantised(controller: Any) -> tuple[Gain, ...]:
    """Return the gains of `limit_observer_step` for its C form.

    Raises
    ------
    FrictionloopError
        When one does not fit: the largest amplitude must be below 8 um, tau/ln 2 above 1/32 um^-2 and below 8/margin,
        and what the most vibration takes of log2 L below 27.
    """
    own, dt = limit_observer_gains(controller), 1.0 / controller.rate_hz
    decay = own.decay_rest * own.decay_left
    sensor = {name: (getattr(own, name), ROW) for name in ("a11", "a12", "a21", "a22", "a31", "a32", "a33")}
    corrections = ("kd", "k1", "k2", "k3", "kds", "kfs", "k1s", "k2s", "k3s")
    before = {
        "decay_rest": (own.decay_rest, 30), "decay_left": (own.decay_left, 30), "decay": (decay, 30),
        "1/(1 - decay)": (1.0 / (1.0 - decay), 24),
    }  # fmt: skip
    after = {
        "controller.slip_length_um": (own.slip_um, 20), "period in us": (1e6 * dt, 20),
        "controller.model.max_amplitude_um": (own.most_um, 28), "its square": (own.most_um**2, 25),
        "log2 of controller.model.nominal_n": (own.log2_nominal, 26), "ln 2 / tau": (1.0 / own.model_fall, 26),
        "tau / ln 2": (own.model_fall, 28), "controller.susceptibility_margin times it": (own.fall, 28),
    }  # fmt: skip
    taken = "susceptibility_margin tau / ln 2 max_amplitude_um^2"
    to_places(own.fall * own.most_um**2 + LARGEST_LOG2, 26, taken)
    return (
        *(to_fixed(value, places, name) for name, (value, places) in (before | sensor).items()),
        *(to_fixed(getattr(own, name), 28 if name.endswith("s") else CORRECTING, name) for name in corrections),
        *(to_fixed(value, places, name) for name, (value, places) in after.items()),
    )
