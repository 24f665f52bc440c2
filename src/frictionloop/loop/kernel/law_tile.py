"""The tile of a control law, with the lookup table and the overdrive behind it."""

from __future__ import annotations

from typing import Any

from frictionloop.control.law import Law
from frictionloop.control.lookup import interpolate_step, inverse_step, overdrive_step, table_position
from frictionloop.loop.kernel.slab import ROW, law_rows
from frictionloop.loop.kernel.slab_access import doubles
from frictionloop.loop.kernel.step_lifting import Lifting, lift, lift_gather
from frictionloop.quantities.scalar_math import is_compiled, step

_U, _MODEL, _COMMAND = ROW["u"], ROW["model"], ROW["command"]
_INVERSE, _WANTED = _MODEL[:2], (ROW["u"], ROW["saturated"])


@step
def limits_step(low: float, high: float, log2_nominal: float, um2_per_halving: float) -> tuple[float, float]:
    """The commands at the limits of the clamp."""
    return inverse_step(low, log2_nominal, um2_per_halving), inverse_step(high, log2_nominal, um2_per_halving)


def build_law(lifting: Lifting, law: Law, table: bool) -> Any:
    """Lift a law's tick with what is behind it: the overdrive makes the plate overshoot, if it believes in its lag."""
    decide, limits, own = lift_law(lifting, law, table), lift_limits(lifting, law), (ROW["overdrive"], _COMMAND)
    overdrive = lift(lifting, overdrive_step, (*own, ROW["overdrive_gains"]), own)

    @lifting.compiled
    def control(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if k == 0:
            limits(s, n)
        decide(s, n, o)
        overdrive(s, n)

    return control


def lift_law(lifting: Lifting, law: Law, table: bool) -> Any:
    """Return ``decide(s, n, o)``: what a law does in a tick, and the command for the force that it decides on.

    With the exact inverse law and lookup are one loop, so that the force command stays in a register. A law in plain
    Python has decided before (loop/kernel/foreign_tile).
    """
    state, gains, _ = law_rows(law)
    law_step, branches = law.step, lifting.width == 1

    @step
    def decide_step(dt, state, measured, setpoint_n, gains, at_limits, model):  # type: ignore[no-untyped-def]
        state, wanted = law_step(state, measured, setpoint_n, gains, dt)
        if table:  # looked up after all lanes have decided
            return state, wanted, 0.0
        # A lane alone waits for the logarithm and the root; at a limit of the clamp their result is known, and the
        # processor, which predicts the branch, runs ahead. Lanes in a tile would only lose by it.
        if branches and wanted[0] == gains.low:
            command_um = at_limits[0]
        elif branches and wanted[0] == gains.high:
            command_um = at_limits[1]
        else:
            command_um = inverse_step(wanted[0], *model)
        return state, wanted, command_um

    @step
    def decided_step(dt, u, model):  # type: ignore[no-untyped-def]
        return inverse_step(u, *model)

    given = state, ROW["measurement"], ROW["setpoint"], gains, ROW["at_limits"], _INVERSE
    tick = lift(lifting, decide_step, given, (state, _WANTED, _COMMAND))
    if not is_compiled(law_step):
        tick = lift(lifting, decided_step, (_U, _INVERSE), _COMMAND)
    look_up = lift_gather(lifting, table_position, interpolate_step, (_U, *_MODEL[2:]), _COMMAND)

    @lifting.compiled
    def decide(s, n, o):  # type: ignore[no-untyped-def]
        tick(s, n, o.dt)
        if table:
            look_up(s, n, doubles(o.table))

    return decide


def lift_limits(lifting: Lifting, law: Law) -> Any:
    """Return what prepares the commands at the limits of the clamp."""
    return lift(lifting, limits_step, (*law_rows(law)[1][-2:], *_INVERSE), ROW["at_limits"])
