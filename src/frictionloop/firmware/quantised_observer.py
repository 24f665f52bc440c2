"""The observer of the friction force in the firmware's numbers (firmware/core/fl_observer.h), and the laws on it."""

from __future__ import annotations

from typing import Any

from frictionloop.control.force_observer import ObserverGains
from frictionloop.control.observer_gains import observer_gains
from frictionloop.control.super_twisting import super_twisting_gains
from frictionloop.firmware.quantised import Gain, to_fixed, to_gain, to_row

FORCE, SENSOR = 28, 26
"""Binary places of forces on the finger and of those behind the sensor's springs, which ring."""
OBSERVER_PLACES = (FORCE, FORCE, SENSOR, SENSOR, SENSOR, FORCE, FORCE, 0, 0, *[FORCE] * 9)
SUPER_TWISTING_PLACES = (*OBSERVER_PLACES, FORCE, FORCE, FORCE)
_FROM = {"p": FORCE, "o": FORCE, "n": FORCE, "d": FORCE, "1": SENSOR, "2": SENSOR, "3": SENSOR}
_ROWS = {"p": FORCE, "x1": SENSOR, "x2": SENSOR, "x3": SENSOR}


def disturbance_observer_quantised(controller: Any) -> tuple[Gain, ...]:
    """Return the gains of `disturbance_observer_step` for its C form."""
    return (*_observer(observer_gains(controller)), _flag(controller.overdrive))


def super_twisting_quantised(controller: Any) -> tuple[Gain, ...]:
    """Return the gains of `super_twisting_step` for its C form, which takes the square of the reach besides it."""
    observer, reach, band, fastest, overdriven, _, _ = super_twisting_gains(controller)
    own = {"controller.k1 dt": reach, "(controller.k1 dt)^2": reach**2, "controller.k2 dt^2": band, "fastest": fastest}
    fixed = [to_fixed(value, FORCE, name) for name, value in own.items()]
    return (*_observer(observer), *fixed, _flag(overdriven))


def _observer(gains: ObserverGains) -> list[Gain]:
    found: dict[str, Gain] = {}
    for row, places in _ROWS.items():
        names = [name for name in ObserverGains._fields[:22] if name.startswith(row)]
        values, inputs = [getattr(gains, name) for name in names], [_FROM[name[-1]] for name in names]
        found |= dict(zip(names, to_row(values, inputs, places, f"believed {row}"), strict=True))
    found |= {name: to_gain(getattr(gains, name), name) for name in ("k1", "k2", "k3", "kd", "inverse")}
    found["whole"] = to_fixed(gains.whole, 0, "whole periods of controller.delay_s")
    found["limit"] = to_fixed(gains.limit, FORCE, "largest disturbance, 2 controller.model.nominal_n")
    return [found[name] for name in ObserverGains._fields]


def _flag(value: float) -> Gain:
    return Gain(int(value), 0)
