"""The plant of the bench over one control period: substeps of finger and suspension under the commands in force."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.finger_tile import build_finger, rigid_step
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.contact_bristle import dahl_step, lugre_step
from frictionloop.physics.contact_slider import slider_step
from frictionloop.quantities.normals import BLOCK


def build_bench(lifting: Lifting, spread: Any, suspend: Any) -> tuple[Any, Any]:
    """Return the tile of a finger's substep under any contact law, and that of the plant.

    ``o`` are the options of the loop, ``b`` its buffers (loop/kernel/exchange.py).
    """
    compiled, driven = lifting.compiled, ROW["driven"]
    rigid, dahl, lugre, slider = (
        build_finger(lifting, law) for law in (rigid_step, dahl_step, lugre_step, slider_step)
    )

    @compiled
    def finger(s, n, contact, j, of):  # type: ignore[no-untyped-def]
        if contact == 0:
            rigid(s, n, j, of)
        elif contact == 1:
            dahl(s, n, j, of)
        elif contact == 2:
            lugre(s, n, j, of)
        else:
            slider(s, n, j, of)

    @compiled
    def plant(s, n, at, o, b):  # type: ignore[no-untyped-def]
        for j in range(o.segments):
            spread(s, n, driven, b.disturbance, (j + 1) * BLOCK + at, o.disturbance_shared)
            finger(s, n, o.contact, float(j), float(o.segments))
            suspend(s, n)

    return finger, plant
