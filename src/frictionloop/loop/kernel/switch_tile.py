"""The tiles that run a law while the loop is open or closes (control/switch): before its tick, and after it."""

from __future__ import annotations

from typing import Any

from frictionloop.control.law import Law
from frictionloop.control.laws import LAWS
from frictionloop.control.switch import CLOSING, switched_clamp
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.slab_access import load, peek, poke, store
from frictionloop.loop.kernel.tiles import Lifting


def build_switch(lifting: Lifting, limits: Any) -> tuple[Any, Any]:
    """Return the tile that sets the clamp before a tick, and the one that tells the law what was commanded in it."""
    width, compiled, count = lifting
    setpoint, u, saturated = ROW["setpoint"], ROW["u"], ROW["saturated"]
    clamp, believed = rows("clamp"), rows("believed_clamp")
    begin = _of_each(lifting, {k: _begin(lifting, law) for k, law in enumerate(LAWS, 1) if law.begin})
    follow = _of_each(lifting, {k: _follow(lifting, law) for k, law in enumerate(LAWS, 1) if law.follow})

    @compiled
    def prepare(s, n, since, law):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            low, high = load(s, i, width, believed)
            store(s, i, width, clamp, switched_clamp(peek(s, setpoint * width + i), low, high, since))
        limits(s, n)
        if since == 0:
            begin(s, n, law)

    @compiled
    def tell(s, n, since, law):  # type: ignore[no-untyped-def]
        if since < 0:
            for i in range(count(n)):
                beyond = peek(s, u * width + i) != peek(s, setpoint * width + i)
                poke(s, saturated * width + i, 1.0 if beyond else 0.0)
        if since < CLOSING:
            follow(s, n, law)

    return prepare, tell


def _begin(lifting: Lifting, law: Law) -> Any:
    width, compiled, count = lifting
    step, state, setpoint, low = law.begin, ROW["controller_state"], ROW["setpoint"], ROW["clamp"]
    gain_rows = rows("controller_gains", law.gains)

    @compiled
    def begin(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            force, gains = peek(s, low * width + i), load(s, i, width, gain_rows)
            poke(s, state * width + i, step(force, peek(s, setpoint * width + i), gains))

    return begin


def _follow(lifting: Lifting, law: Law) -> Any:
    width, compiled, count = lifting
    step, command = law.follow, ROW["command"]
    state_rows, gain_rows = rows("controller_state", law.states), rows("controller_gains", law.gains)

    @compiled
    def follow(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            state, gains = load(s, i, width, state_rows), load(s, i, width, gain_rows)
            store(s, i, width, state_rows, step(state, peek(s, command * width + i), gains))

    return follow


def _of_each(lifting: Lifting, tiles: dict[int, Any]) -> Any:
    """Return a tile that runs that of the law's number, if there is one."""

    @lifting.compiled
    def nothing(s, n, law):  # type: ignore[no-untyped-def]
        return

    chosen = nothing
    for number, tile in tiles.items():
        chosen = _either(lifting, number, tile, chosen)
    return chosen


def _either(lifting: Lifting, number: int, tile: Any, others: Any) -> Any:
    @lifting.compiled
    def choose(s, n, law):  # type: ignore[no-untyped-def]
        if law == number:
            tile(s, n)
        else:
            others(s, n, law)

    return choose
