"""The tiles that put a finger and its sensor into their state at t = 0, and that tell f_a and what is reachable."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.motion_tile import DIRECTION, FACTOR, OCCLUDED, SPEED
from frictionloop.loop.slab import ROW, peek, poke
from frictionloop.loop.tiles import Lifting
from frictionloop.physics.friction_limit import vibrated_step
from frictionloop.quantities.arithmetic import fma

CREEP_M_S = 1e-3
"""Speed above which a finger is sliding already at t = 0 (assumed)."""


def build_start(lifting: Lifting) -> tuple[Any, Any]:
    """Return ``settle``: finger and sensor before t = 0 have had time enough; and ``tell``: f_a and its band at t_k."""
    width, compiled, count = lifting
    now, contact, force = ROW["motion"], ROW["contact"], ROW["contact_force"]
    limit_row, per_bristle, compliance = ROW["limit_n"], ROW["contact_coefficients"] + 7, ROW["compliance"]
    springs, disturbance, friction_row = ROW["suspension"], ROW["disturbance"], ROW["friction"]
    floor, nominal, ceiling = ROW["floor"], ROW["nominal"], ROW["max_amplitude"]
    per_halving, loss = ROW["halving_amplitude"] + 1, ROW["moist_loss"]

    @compiled
    def settle(s, n, stiff):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            speed = peek(s, (now + SPEED) * width + i)
            limit = peek(s, limit_row * width + i) * peek(s, (now + FACTOR) * width + i)
            f = limit if speed >= CREEP_M_S else (-limit if speed <= -CREEP_M_S else 0.0)
            f = (limit if speed >= 0.0 else -limit) if stiff else f
            poke(s, force * width + i, f)
            poke(s, contact * width + i, f * peek(s, compliance * width + i))
            poke(s, (contact + 2) * width + i, f * peek(s, per_bristle * width + i))
            poke(s, (contact + 3) * width + i, limit * peek(s, per_bristle * width + i))
            pushed = fma(peek(s, (now + DIRECTION) * width + i), peek(s, disturbance * width + i), f)
            poke(s, springs * width + i, pushed)
            poke(s, (springs + 2) * width + i, pushed)

    @compiled
    def tell(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(s, friction_row * width + i, peek(s, (now + DIRECTION) * width + i) * peek(s, force * width + i))
            top = peek(s, limit_row * width + i) * peek(s, (now + FACTOR) * width + i)
            poke(s, nominal * width + i, top)
            y, occluded = (
                peek(s, ceiling * width + i) * peek(s, per_halving * width + i),
                peek(s, (now + OCCLUDED) * width + i),
            )
            poke(s, floor * width + i, top * vibrated_step(y, occluded, peek(s, loss * width + i)))

    return settle, tell
