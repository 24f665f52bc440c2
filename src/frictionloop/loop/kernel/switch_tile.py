"""The tiles that run a law while the loop is open or closes (control/switch): before its tick, and after it."""

from __future__ import annotations

from typing import Any

from frictionloop.control.law import Law
from frictionloop.control.switch import CLOSING, switched_clamp
from frictionloop.loop.kernel.access import load, peek, poke, store
from frictionloop.loop.kernel.law_tile import lift_limits
from frictionloop.loop.kernel.slab import ROW, law_rows, rows
from frictionloop.loop.kernel.tiles import Lifting


def build_prepare(lifting: Lifting, law: Law) -> Any:
    """Return the tile that sets the clamp before a tick, and lets an integral begin where the loop closes."""
    width, compiled, count = lifting
    setpoint, believed, (state_rows, gain_rows) = ROW["setpoint"], rows("believed_clamp"), law_rows(law)
    clamp, begins, step = tuple(gain_rows[-2:]), law.begin is not None, law.begin
    limits, _ = lift_limits(lifting, law)

    @compiled
    def prepare(s, n, k, at, o):  # type: ignore[no-untyped-def]
        since = k - o.open_until
        if since > CLOSING:
            return
        for i in range(count(n)):
            low, high = load(s, i, width, believed)
            store(s, i, width, clamp, switched_clamp(peek(s, setpoint * width + i), low, high, since))
        limits(s, n)
        if begins and since == 0:
            for i in range(count(n)):
                state, gains = load(s, i, width, state_rows), load(s, i, width, gain_rows)
                state = step(state, peek(s, clamp[0] * width + i), peek(s, setpoint * width + i), gains)
                store(s, i, width, state_rows, state)

    return prepare


def build_tell(lifting: Lifting, law: Law) -> Any:
    """Return the tile that tells a law what was commanded in its tick."""
    width, compiled, count = lifting
    setpoint, u, saturated, command = ROW["setpoint"], ROW["u"], ROW["saturated"], ROW["command"]
    (state_rows, gain_rows), follows, step = law_rows(law), law.follow is not None, law.follow

    @compiled
    def tell(s, n, k, at, o):  # type: ignore[no-untyped-def]
        since = k - o.open_until
        if since < 0:
            for i in range(count(n)):
                beyond = peek(s, u * width + i) != peek(s, setpoint * width + i)
                poke(s, saturated * width + i, 1.0 if beyond else 0.0)
        if follows and since < CLOSING:
            for i in range(count(n)):
                state, gains = load(s, i, width, state_rows), load(s, i, width, gain_rows)
                store(s, i, width, state_rows, step(state, peek(s, command * width + i), gains))

    return tell
