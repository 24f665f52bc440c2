"""The lookup table alone: the set-point commands the force and nothing is fed back (Section 2.2, ref. [15])."""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.control.law import Clamp, ForceCommand, Law, clamp_of
from frictionloop.quantities.arithmetic import step
from frictionloop.sensing.measurement import Measurement


class NoState(NamedTuple):
    """The table remembers nothing; the number is not used."""

    nothing: float


@step
def open_loop_step(
    state: NoState, measurement: Measurement, setpoint_n: float, gains: Clamp, dt: float
) -> tuple[NoState, ForceCommand]:
    """u = clip(f_r, low, high), whatever is measured."""
    low, high = gains
    u = min(max(setpoint_n, low), high)
    return state, ForceCommand(u, 1.0 if setpoint_n != u else 0.0)


LOOKUP_LAW = Law("lookup", open_loop_step, NoState, Clamp, lambda c: clamp_of(c.model))
