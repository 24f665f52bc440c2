"""The plant of the bench over one control period: substeps of finger and suspension under the command in force."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.finger_tile import build_finger, build_hold, rigid_step
from frictionloop.loop.slab import ROW
from frictionloop.loop.tiles import Lifting
from frictionloop.physics.contact_bristle import dahl_step, lugre_step
from frictionloop.physics.contact_slider import slider_step
from frictionloop.quantities.normals import BLOCK


def build_bench(lifting: Lifting, spread: Any, suspend_before: Any, suspend_after: Any) -> Any:
    """Return the tile of the plant; ``o`` are the options of the loop, ``b`` its buffers (loop/exchange.py)."""
    compiled, hold = lifting.compiled, build_hold(lifting)
    (rigid_0, rigid_1), (dahl_0, dahl_1), (lugre_0, lugre_1), (slider_0, slider_1) = (
        build_finger(lifting, law) for law in (rigid_step, dahl_step, lugre_step, slider_step)
    )
    command, applied, driven = ROW["command"], ROW["applied"], ROW["driven"]

    @compiled
    def finger_before(s, n, contact, fraction):  # type: ignore[no-untyped-def]
        if contact == 0:
            rigid_0(s, n, fraction)
        elif contact == 1:
            dahl_0(s, n, fraction)
        elif contact == 2:
            lugre_0(s, n, fraction)
        else:
            slider_0(s, n, fraction)
        suspend_before(s, n)

    @compiled
    def finger_after(s, n, contact, fraction):  # type: ignore[no-untyped-def]
        if contact == 0:
            rigid_1(s, n, fraction)
        elif contact == 1:
            dahl_1(s, n, fraction)
        elif contact == 2:
            lugre_1(s, n, fraction)
        else:
            slider_1(s, n, fraction)
        suspend_after(s, n)

    @compiled
    def plant(s, n, at, o, b):  # type: ignore[no-untyped-def]
        switch = o.switch
        for j in range(o.segments):
            spread(s, n, driven, b.disturbance, (j + 1) * BLOCK + at, o.disturbance_shared)
            if j == 0 and o.before > 0:
                hold(s, n, applied)
            if j == o.before:
                hold(s, n, command if o.ring_mask == 0 else applied + 1)
            if j < o.before:
                finger_before(s, n, o.contact, switch * (j + 0.5) / o.before)
            else:
                part = (j - o.before + 0.5) / (o.segments - o.before)
                finger_after(s, n, o.contact, switch + (1.0 - switch) * part)

    return plant
