"""The tile of the plant: plate, friction law and sensor over a stretch of constant command."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import load, peek, store
from frictionloop.loop.kernel.ends import TERMS, end_step
from frictionloop.loop.kernel.slab import ROW, SEGMENT_ROWS
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.friction import remaining_step
from frictionloop.physics.plate import limit_step, lowpass_step
from frictionloop.sensing.lowpass import sensor_node, sensor_start


def build_plant(lifting: Lifting) -> Any:
    """Lift plate, friction law and sensor over one segment of the period (loop/kernel/ends.py).

    Inside, the amplitude is counted in the amplitude that halves friction, and the terms of the end carry f0. The
    disturbance's share of the reading is already summed over the nodes.
    """
    width, compiled, count = lifting
    segment_row = ROW["segment"]
    force, friction_row, amplitude, driven = ROW["measurement"], ROW["friction"], ROW["amplitude"], ROW["driven"]
    sensor_rows = (force, ROW["normal"], ROW["sensor_decay"], ROW["noise_gain"])
    halving, nominal, ceiling = ROW["halving_amplitude"], ROW["nominal"], ROW["max_amplitude"]
    after = (force, amplitude, friction_row)

    @compiled
    def terms(s, row, i):  # type: ignore[no-untyped-def]
        at = row * width + i
        low = peek(s, at), peek(s, at + width), peek(s, at + 2 * width)
        return (*low, peek(s, at + 3 * width), peek(s, at + 4 * width), peek(s, at + 5 * width))

    @compiled
    def plant(s, n, command, segment):  # type: ignore[no-untyped-def]
        first = segment_row + segment * SEGMENT_ROWS
        for i in range(count(n)):
            unit, per_unit = peek(s, halving * width + i), peek(s, (halving + 1) * width + i)
            start = peek(s, amplitude * width + i) * per_unit
            held = limit_step(peek(s, command * width + i), peek(s, ceiling * width + i)) * per_unit
            if segment == 0:
                f_m = sensor_start(*load(s, i, width, sensor_rows)) + peek(s, driven * width + i)
            else:
                f_m = peek(s, force * width + i)
            decay, away = peek(s, first * width + i), start - held
            before = end_step(start, away, *terms(s, first + 1, i))
            f_m = sensor_node(f_m, peek(s, friction_row * width + i), before)
            y = lowpass_step(start, held, decay)
            remaining = remaining_step(y)
            f_m = sensor_node(f_m, remaining, end_step(y, away * decay, *terms(s, first + 1 + TERMS, i)))
            g = peek(s, nominal * width + i) * remaining
            store(s, i, width, after, (f_m, y * unit, g))

    return plant
