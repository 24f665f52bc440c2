"""The tiles of an imperfect clock: commands that come late by chance, and ticks that are lost."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.slab import COUNT, ROW
from frictionloop.loop.kernel.slab_access import peek, poke
from frictionloop.loop.kernel.tiles import Lifting


def build_timing(lifting: Lifting) -> tuple[Any, Any, Any]:
    """Return the tiles that say when the command changes, and that keep and restore what a lost tick would change."""
    width, compiled, count = lifting
    switch, timing, draws, kept = ROW["switch"], ROW["timing"], ROW["timing_draws"], ROW["kept"]
    state, state_count = ROW["controller_state"], COUNT["controller_state"]
    u, saturated, command, believed = ROW["u"], ROW["saturated"], ROW["command"], ROW["overdrive"]

    @compiled
    def time_switch(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            late = peek(s, (timing + 1) * width + i) * abs(peek(s, draws * width + i))
            poke(s, switch * width + i, min(peek(s, timing * width + i) + late, 1.0))

    @compiled
    def keep(s, n):  # type: ignore[no-untyped-def]
        for row in range(state_count):
            for i in range(count(n)):
                poke(s, (kept + row) * width + i, peek(s, (state + row) * width + i))
        for i in range(count(n)):
            poke(s, (kept + state_count) * width + i, peek(s, u * width + i))
            poke(s, (kept + state_count + 1) * width + i, peek(s, saturated * width + i))
            poke(s, (kept + state_count + 2) * width + i, peek(s, command * width + i))
            poke(s, (kept + state_count + 3) * width + i, peek(s, believed * width + i))

    @compiled
    def choose(s, n, row, saved):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            lost = peek(s, (draws + 1) * width + i) < peek(s, (timing + 2) * width + i)
            value, before = peek(s, row * width + i), peek(s, (kept + saved) * width + i)
            poke(s, row * width + i, before if lost else value)

    @compiled
    def restore(s, n):  # type: ignore[no-untyped-def]
        for row in range(state_count):
            choose(s, n, state + row, row)
        choose(s, n, u, state_count)
        choose(s, n, saturated, state_count + 1)
        choose(s, n, command, state_count + 2)
        choose(s, n, believed, state_count + 3)

    return time_switch, keep, restore
