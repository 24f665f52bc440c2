"""The tiles of all control laws behind one number, and the overdrive that follows any of them."""

from __future__ import annotations

from typing import Any

from frictionloop.control.laws import LAWS
from frictionloop.control.overdrive import OverdriveGains, overdrive_step
from frictionloop.loop.kernel.control_tile import build_control
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.slab_access import load, peek, poke
from frictionloop.loop.kernel.tiles import Lifting


def build_laws(lifting: Lifting) -> tuple[Any, Any]:
    """Return the tile that decides by the law of a number, and one that prepares the commands at the clamp's limits."""
    tiles = [build_control(lifting, law) for law in LAWS]
    decide = tiles[-1][0]
    for number in range(len(tiles) - 1, 0, -1):
        decide = _either(lifting, number, tiles[number - 1][0], decide)
    return _with_overdrive(lifting, decide), tiles[0][1]


def _either(lifting: Lifting, number: int, tile: Any, others: Any) -> Any:
    @lifting.compiled
    def choose(s, n, law, dt, table, table_size):  # type: ignore[no-untyped-def]
        if law == number:
            tile(s, n, law, dt, table, table_size)
        else:
            others(s, n, law, dt, table, table_size)

    return choose


def _with_overdrive(lifting: Lifting, decide: Any) -> Any:
    width, compiled, count = lifting
    command, believed, gain_rows = ROW["command"], ROW["overdrive"], rows("overdrive_gains")

    @compiled
    def control(s, n, law, dt, table, table_size):  # type: ignore[no-untyped-def]
        decide(s, n, law, dt, table, table_size)
        for i in range(count(n)):
            gains = OverdriveGains(*load(s, i, width, gain_rows))
            a, c = overdrive_step(peek(s, believed * width + i), peek(s, command * width + i), gains)
            poke(s, believed * width + i, a)
            poke(s, command * width + i, c)

    return control
