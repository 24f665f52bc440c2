"""The tiles of ticks out of the ordinary: the loop open or closing, commands that come late, ticks that are lost."""

from __future__ import annotations

from typing import Any

from frictionloop.control.law import CLOSING, Law, switched_clamp
from frictionloop.loop.kernel.law_tile import lift_limits
from frictionloop.loop.kernel.slab import ROW, law_rows
from frictionloop.loop.kernel.slab_access import doubles, load, store
from frictionloop.loop.kernel.step_lifting import Lifting, lift, same_step
from frictionloop.quantities.scalar_math import step

_COMMANDS = tuple(ROW[name] for name in ("u", "saturated", "command", "overdrive"))


@step
def clamp_step(since: int, setpoint_n: float, low_n: float, high_n: float) -> tuple[float, float]:
    """The clamp so many periods after the loop closed."""
    return switched_clamp(setpoint_n, low_n, high_n, since)


@step
def beyond_step(u: float, setpoint_n: float) -> float:
    """Whether the lookup alone commands another force than the set-point."""
    return 1.0 if u != setpoint_n else 0.0


@step
def late_step(plain: float, jitter: float, _lost_below: float, normal: float) -> float:
    """When in the period the command changes, 0 to 1."""
    return min(plain + jitter * abs(normal), 1.0)


@step
def lost_step(drawn, below, now, kept):  # type: ignore[no-untyped-def]
    """What a tick has left, or what was before it if the tick is lost."""
    return kept if drawn < below else now


def build_prepare(lifting: Lifting, law: Law) -> Any:
    """Return the tile that sets the clamp before a tick, and lets an integral begin where the loop closes."""
    state, gains, _ = law_rows(law)
    clamp = lift(lifting, clamp_step, (ROW["setpoint"], *ROW["believed_clamp"]), tuple(gains[-2:]))
    limits, begins = lift_limits(lifting, law), law.begin is not None
    begin = lift(lifting, law.begin, (state, gains[-2], ROW["setpoint"], gains), state)

    @lifting.compiled
    def prepare(s, n, k, at, o):  # type: ignore[no-untyped-def]
        since = k - o.open_until
        if since > CLOSING:
            return
        clamp(s, n, since)
        limits(s, n)
        if begins and since == 0:
            begin(s, n)

    return prepare


def build_tell(lifting: Lifting) -> Any:
    """Return the tile that tells whether open loop commands another force than the set-point."""
    compare = lift(lifting, beyond_step, (ROW["u"], ROW["setpoint"]), ROW["saturated"])

    @lifting.compiled
    def tell(s, n, k, at, o):  # type: ignore[no-untyped-def]
        if k < o.open_until:
            compare(s, n)

    return tell


def lift_delay(lifting: Lifting) -> Any:
    """Return what picks the commands in force during a period when they are applied later than the sample."""
    width, compiled, count = lifting
    command, (before, after), delay = ROW["command"], ROW["applied"], ROW["delay_periods"]

    @compiled
    def apply_late(s, n, k, o):  # type: ignore[no-untyped-def]
        history, mask = doubles(o.history), o.ring_mask
        for i in range(count(n)):
            store(history, i, width, k & mask, load(s, i, width, command))
            since = k - int(load(s, i, width, delay))
            store(s, i, width, after, load(history, i, width, since & mask))
            store(s, i, width, before, load(history, i, width, (since - 1) & mask))

    return apply_late


def build_lost(lifting: Lifting, law: Law, after: bool) -> Any:
    """Return the tile that keeps what a tick may change before it, and ``after`` it takes back one that was lost."""
    own = law_rows(law)[2]
    rows, kept = (*_COMMANDS, *ROW["law"][: len(own)]), (*ROW["kept"], *own)
    part = lift(lifting, same_step, (rows,), kept)
    if after:
        part = lift(lifting, lost_step, (ROW["timing_draws"][1], ROW["timing"][2], rows, kept), rows)

    @lifting.compiled
    def lost(s, n, k, at, o):  # type: ignore[no-untyped-def]
        part(s, n)

    return lost
