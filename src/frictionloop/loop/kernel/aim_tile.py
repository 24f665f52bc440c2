"""Where an oracle aims: the force it wants of the contact, and the amplitude that puts the friction limit there."""

from __future__ import annotations

import math
from typing import Any

from frictionloop.loop.kernel.motion_tile import FACTOR, OCCLUDED, SPEED
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.slab_access import load, peek, poke
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.friction_limit import static_step
from frictionloop.quantities.arithmetic import fma, log2, step
from frictionloop.quantities.normals import BLOCK

LEAST_N = 1e-9
"""Least force whose logarithm is taken: below any that can be asked for."""
SETPOINT, LAST, COMMAND, ERROR, COMMAND_BEFORE, ERROR_BEFORE, SLOPE = range(7)
"""Rows of ``trial``."""


@step
def drive_step(amplitude_um: float, wanted_um: float, decay: float) -> float:
    """(a_w - p a)/(1 - p): the command, which the drive may not reach, that takes the plate there in one period."""
    return fma(-decay, amplitude_um, wanted_um) / (1.0 - decay)


@step
def amplitude_step(limit_n: float, wanted_n: float, effect: float) -> float:
    """sqrt(log2(F_max/f) / (1 - l w)), at least 0: amplitude that leaves f, in halving amplitudes."""
    octaves = log2(max(limit_n, LEAST_N)) - log2(max(wanted_n, LEAST_N))
    return math.sqrt(max(octaves, 0.0) / effect)


def build_aim(lifting: Lifting, spread: Any) -> tuple[Any, Any]:
    """Return the tiles that say which force is wanted, and which amplitudes and first command would give it."""
    width, compiled, count = lifting
    trial, decay, amplitude, contact = ROW["trial"], ROW["trial_decay"], ROW["amplitude"], ROW["contact"]
    now, after, driven, disturbance = ROW["motion"], ROW["motion_next"], ROW["driven"], ROW["disturbance"]
    halving, ceiling, saturated = ROW["halving_amplitude"], ROW["max_amplitude"], ROW["saturated"]
    limit_row, moist, static_rows = ROW["limit_n"], ROW["moist_loss"], rows("static")

    @compiled
    def want(s, n, at, o, b):  # type: ignore[no-untyped-def]
        # A clairvoyant's signals are those of t_k+1: the next sample of the set-point, if its block is drawn, and the
        # disturbance on a line through t_k and the middle of the last substep.
        ahead = 0.0
        spread(s, n, trial, b.setpoint, at, o.setpoint_shared)
        if o.plan.preview:
            ahead = o.segments / (o.segments - 0.5)
            spread(s, n, trial, b.setpoint, min(at + 1, BLOCK - 1), o.setpoint_shared)
            spread(s, n, driven, b.disturbance, o.segments * BLOCK + at, o.disturbance_shared)
        for i in range(count(n)):
            r, d = peek(s, trial * width + i), peek(s, disturbance * width + i)
            r = r - fma(ahead, peek(s, driven * width + i) - d, d) if o.plan.preview else r - d
            poke(s, trial * width + i, r)

    @compiled
    def amplitude_at(s, i, fraction):  # type: ignore[no-untyped-def]
        factor, speed = peek(s, (now + FACTOR) * width + i), peek(s, (now + SPEED) * width + i)
        factor = max(fma(fraction, peek(s, (after + FACTOR) * width + i) - factor, factor), 0.0)
        speed = fma(fraction, peek(s, (after + SPEED) * width + i) - speed, speed)
        gain, per_speed = load(s, i, width, static_rows)
        slip = speed - peek(s, (contact + 1) * width + i)
        limit = peek(s, limit_row * width + i) * factor * static_step(slip, gain, per_speed)
        effect = fma(-peek(s, moist * width + i), peek(s, (now + OCCLUDED) * width + i), 1.0)
        y = amplitude_step(limit, peek(s, (trial + SETPOINT) * width + i), effect)
        return min(y * peek(s, halving * width + i), peek(s, ceiling * width + i))

    @compiled
    def aim(s, n, o):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            first, top = amplitude_at(s, i, 1.0), peek(s, ceiling * width + i)
            poke(s, (trial + LAST) * width + i, amplitude_at(s, i, 2.0 - 0.5 / o.plan.steps))
            wanted = drive_step(peek(s, amplitude * width + i), first, peek(s, decay * width + i))
            poke(s, (trial + COMMAND) * width + i, min(max(wanted, 0.0), top))
            poke(s, saturated * width + i, 1.0 if (wanted < 0.0) | (wanted > top) else 0.0)

    return want, aim
