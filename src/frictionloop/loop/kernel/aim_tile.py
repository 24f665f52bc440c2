"""Where an oracle aims: the force it wants of the contact, and the amplitude that puts the friction limit there."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles, load, peek, poke
from frictionloop.loop.kernel.motion_tile import NEXT, NOW
from frictionloop.loop.kernel.slab import ROW, rows, vibration_rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.friction_limit import static_step
from frictionloop.physics.vibration import Vibration, inverse_of
from frictionloop.quantities.arithmetic import fma, step
from frictionloop.quantities.normals import BLOCK

SETPOINT, LAST, COMMAND, ERROR, COMMAND_BEFORE, ERROR_BEFORE, SLOPE = range(7)
"""Rows of ``trial``."""


@step
def drive_step(amplitude_um: float, wanted_um: float, decay: float) -> float:
    """(a_w - p a)/(1 - p): the command, which the drive may not reach, that takes the plate there in one period."""
    return fma(-decay, amplitude_um, wanted_um) / (1.0 - decay)


def lift_aim(lifting: Lifting, spread: Any, vibration: Vibration) -> tuple[Any, Any]:
    """Return the tiles that say which force is wanted, and which amplitudes and first command would give it."""
    width, compiled, count = lifting
    trial, decay, amplitude, contact = ROW["trial"], ROW["trial_decay"], ROW["amplitude"], ROW["contact"]
    driven, disturbance = ROW["driven"], ROW["disturbance"]
    ceiling, saturated, limit_row, static_rows = ROW["max_amplitude"], ROW["saturated"], ROW["limit_n"], rows("static")
    inverse, effect_rows = inverse_of(vibration), vibration_rows(vibration)

    @compiled
    def want(s, n, at, o):  # type: ignore[no-untyped-def]
        # A clairvoyant's signals are those of t_k+1: the next sample of the set-point, if its block is drawn, and the
        # disturbance on a line through t_k and the middle of the last substep.
        ahead = 0.0
        spread(s, n, trial, doubles(o.setpoint), at, o.setpoint_shared)
        if o.preview != 0:
            ahead = o.segments / (o.segments - 0.5)
            spread(s, n, trial, doubles(o.setpoint), min(at + 1, BLOCK - 1), o.setpoint_shared)
            spread(s, n, driven, doubles(o.disturbance), o.segments * BLOCK + at, o.disturbance_shared)
        for i in range(count(n)):
            r, d = peek(s, trial * width + i), peek(s, disturbance * width + i)
            r = r - fma(ahead, peek(s, driven * width + i) - d, d) if o.preview != 0 else r - d
            poke(s, trial * width + i, r)

    @compiled
    def amplitude_at(s, i, fraction):  # type: ignore[no-untyped-def]
        factor, speed = peek(s, NOW.factor * width + i), peek(s, NOW.speed * width + i)
        factor = max(fma(fraction, peek(s, NEXT.factor * width + i) - factor, factor), 0.0)
        speed = fma(fraction, peek(s, NEXT.speed * width + i) - speed, speed)
        gain, per_speed = load(s, i, width, static_rows)
        slip = speed - peek(s, (contact + 1) * width + i)
        limit = peek(s, limit_row * width + i) * factor * static_step(slip, gain, per_speed)
        occluded, wanted = peek(s, NOW.occluded * width + i), peek(s, (trial + SETPOINT) * width + i)
        top = peek(s, ceiling * width + i)
        return min(inverse(limit, wanted, occluded, top, load(s, i, width, effect_rows)), top)

    @compiled
    def aim(s, n, o):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            first, top = amplitude_at(s, i, 1.0), peek(s, ceiling * width + i)
            poke(s, (trial + LAST) * width + i, amplitude_at(s, i, 2.0 - 0.5 / o.steps))
            wanted = drive_step(peek(s, amplitude * width + i), first, peek(s, decay * width + i))
            poke(s, (trial + COMMAND) * width + i, min(max(wanted, 0.0), top))
            poke(s, saturated * width + i, 1.0 if (wanted < 0.0) | (wanted > top) else 0.0)

    return want, aim
