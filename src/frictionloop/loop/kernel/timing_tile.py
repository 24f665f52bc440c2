"""The tiles of an imperfect clock: commands that come late by chance, and ticks that are lost."""

from __future__ import annotations

from typing import Any

from frictionloop.control.law import Law
from frictionloop.loop.kernel.access import peek, poke
from frictionloop.loop.kernel.slab import ROW, kept_rows
from frictionloop.loop.kernel.tiles import Lifting

_COMMANDS = tuple(ROW[name] for name in ("u", "saturated", "command", "overdrive"))


def lift_timing(lifting: Lifting) -> Any:
    """Return what says when in the period the command changes."""
    width, compiled, count = lifting
    switch, timing, draws = ROW["switch"], ROW["timing"], ROW["timing_draws"]

    @compiled
    def time_switch(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            late = peek(s, (timing + 1) * width + i) * abs(peek(s, draws * width + i))
            poke(s, switch * width + i, min(peek(s, timing * width + i) + late, 1.0))

    return time_switch


def build_keep(lifting: Lifting, law: Law | None) -> Any:
    """Return the tile that keeps what a lost tick would change."""
    width, compiled, count = lifting
    rows, kept = _rows(law)

    @compiled
    def keep(s, n, k, at, o):  # type: ignore[no-untyped-def]
        for j in range(len(rows)):
            for i in range(count(n)):
                poke(s, kept[j] * width + i, peek(s, rows[j] * width + i))

    return keep


def build_restore(lifting: Lifting, law: Law | None) -> Any:
    """Return the tile that takes back a tick that was lost."""
    width, compiled, count = lifting
    rows, kept = _rows(law)
    draws, timing = ROW["timing_draws"], ROW["timing"]

    @compiled
    def restore(s, n, k, at, o):  # type: ignore[no-untyped-def]
        for j in range(len(rows)):
            for i in range(count(n)):
                lost = peek(s, (draws + 1) * width + i) < peek(s, (timing + 2) * width + i)
                value, before = peek(s, rows[j] * width + i), peek(s, kept[j] * width + i)
                poke(s, rows[j] * width + i, before if lost else value)

    return restore


def _rows(law: Law | None) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the rows that a tick changes, and where they are kept; an oracle and the C core keep no state in rows."""
    kept = tuple(range(ROW["kept"], ROW["kept"] + len(_COMMANDS)))
    if law is None:
        return _COMMANDS, kept
    own = kept_rows(law)
    return (*_COMMANDS, *range(ROW["law"], ROW["law"] + len(own))), (*kept, *own)
