"""The tile that makes the amplitude command one that pulses of whole clock ticks can give."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import peek, poke
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.pulses import pulse_step


def lift_pulses(lifting: Lifting) -> Any:
    """Lift `pulse_step` over the commands in force, whoever gave them."""
    width, compiled, count = lifting
    applied, largest, ticks = ROW["applied"], ROW["max_amplitude"], ROW["pulse_ticks"]

    @compiled
    def pulse(s, n):  # type: ignore[no-untyped-def]
        for row in range(2):
            for i in range(count(n)):
                at = (applied + row) * width + i
                poke(s, at, pulse_step(peek(s, at), peek(s, largest * width + i), peek(s, ticks * width + i)))

    return pulse
