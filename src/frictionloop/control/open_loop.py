"""The lookup table alone: the set-point commands the force and nothing is fed back (Section 2.2, ref. [15])."""

from __future__ import annotations

from frictionloop.control.law import Clamp, ForceCommand
from frictionloop.quantities.arithmetic import step
from frictionloop.sensing.measurement import Measurement


@step
def open_loop_step(
    state: tuple[float], measurement: Measurement, setpoint_n: float, gains: Clamp, dt: float
) -> tuple[tuple[float], ForceCommand]:
    """u = clip(f_r, low, high), whatever is measured."""
    low, high = gains
    u = min(max(setpoint_n, low), high)
    return state, ForceCommand(u, 1.0 if setpoint_n != u else 0.0)
