"""The tile of an effect: its program runs at the place that the controller knows of, and at the true place beside it.

The program is what `rendering.program` says. Lanes of a tile share it; each has its own state.
"""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles, load, store
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.rendering.program import build_play


def build_effect(lifting: Lifting, plain: bool) -> Any:
    """Return the tile that sets the set-point of a period, and what the effect asks for at the true place."""
    width, compiled, count = lifting
    play, clamp = build_play(compiled, width, plain), ROW["believed_clamp"]
    told, touch = ROW["measurement"], ROW["touch_coefficients"].touch_n
    seen, true = (ROW[name].direction * width for name in ("effect_seen", "effect_true"))
    stack = ROW["effect_stack"][0] * width
    predicted = ROW["effect_lead"], ROW["touch"].position, ROW["touch"].speed
    moving, setpoint, intended = ROW["motion"][:3], ROW["setpoint"], ROW["intended"]

    @compiled
    def effect(s, n, k, at, o):  # type: ignore[no-untyped-def]
        p = doubles(o.effect)
        for i in range(count(n)):
            lead, tracked, rate = load(s, i, width, predicted)
            _, position, speed, pressed, _ = load(s, i, width, told)
            along = tracked + lead * rate if lead >= 0.0 else position
            band, touches = load(s, i, width, clamp), load(s, i, width, touch)
            known = 1e3 * along, 1e3 * speed, pressed, touches
            asked, _ = play(s, seen + i, stack + i, p, *known, band, k * o.dt, k == 0, o.dt)
            store(s, i, width, setpoint, asked)
            if o.trace_size > 0:  # what is asked for at the true place is a trace alone
                x, v, load_n = load(s, i, width, moving)
                there = 1e3 * x, 1e3 * v, load_n, 1e-12
                wanted, _ = play(s, true + i, stack + i, p, *there, band, k * o.dt, k == 0, o.dt)
                store(s, i, width, intended, wanted)

    return effect
