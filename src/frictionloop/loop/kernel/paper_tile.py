"""The loop of Section 2: nothing feeds back inside a control period, so one step takes all of it (kernel/ends.py)."""

from __future__ import annotations

from typing import Any

from frictionloop.control.laws import LAWS
from frictionloop.loop.kernel.access import doubles, peek, poke
from frictionloop.loop.kernel.advance import run_program
from frictionloop.loop.kernel.law_tile import lift_law
from frictionloop.loop.kernel.plant_tile import build_plant
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting, lifting
from frictionloop.loop.kernel.traces import build_record, lift_delay, lift_spread
from frictionloop.quantities.normals import BLOCK


def build_paper(blockwise: Lifting) -> Any:
    """Return the tile that runs a block of periods."""
    lift = lifting("paper", blockwise.width, inlined=True)
    width, compiled, count = lift
    pi, limits = lift_law(lift, LAWS["pi"])
    apply_late, plant, spread = lift_delay(lift), build_plant(lift), lift_spread(lift)
    record = build_record(lift, "quadrature")
    command, applied, driven = ROW["command"], ROW["applied"], ROW["driven"]
    setpoint, disturbance, normal = ROW["setpoint"], ROW["disturbance"], ROW["normal"]
    force, friction = ROW["measurement"], ROW["friction"]

    @compiled
    def settle(s, n):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            poke(s, force * width + i, peek(s, friction * width + i) + peek(s, disturbance * width + i))

    @compiled
    def one_period(s, n, k, at, o):  # type: ignore[no-untyped-def]
        spread(s, n, setpoint, doubles(o.setpoint), at, o.setpoint_shared)
        spread(s, n, disturbance, doubles(o.disturbance), at, o.disturbance_shared)
        spread(s, n, normal, doubles(o.normals), at, o.noise_shared)
        spread(s, n, driven, doubles(o.driven), at, o.disturbance_shared)
        if k == 0:
            settle(s, n)
            limits(s, n)
        if o.external == 0:
            pi(s, n, o.dt, doubles(o.table), o.table_size)
        run_program(s, k, at, o.extras, o.extras_count, o)
        if o.trace_size > 0:
            record(s, n, k, at, o)
        if (o.ring_mask == 0) & (o.segments == 1):
            plant(s, n, command, 0)
            return
        apply_late(s, n, k, o)
        for segment in range(o.segments):
            held = applied if segment < o.before else applied + 1
            plant(s, n, held, segment)

    @blockwise.compiled
    def paper(s, n, start, end, o):  # type: ignore[no-untyped-def]
        first = start // BLOCK * BLOCK
        for k in range(start, end):
            one_period(s, n, k, k - first, o)

    return paper
