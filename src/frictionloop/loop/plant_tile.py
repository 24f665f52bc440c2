"""The tile of the plant: plate, friction law and sensor over a stretch of constant command."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.quadrature import NODES
from frictionloop.loop.slab import ROW, load, peek, store
from frictionloop.loop.tiles import compiled_for, lane_count
from frictionloop.physics.friction import friction_step
from frictionloop.physics.plate import limit_step, lowpass_step
from frictionloop.quantities.normals import BLOCK
from frictionloop.sensing.lowpass import sensor_node, sensor_start


def build_plant(width: int) -> Any:
    """Lift plate, friction law and sensor over one segment of the period by quadrature (loop/quadrature.py).

    The number of nodes is a constant, so the loop over nodes unrolls and the loop over lanes vectorises.
    """
    compiled, count = compiled_for(width), lane_count(width)
    decay, weight = ROW["decay"], ROW["weight"]
    force, normal, friction_row, amplitude = ROW["measurement"], ROW["normal"], ROW["friction"], ROW["amplitude"]
    sensor_rows = (force, normal, ROW["sensor_decay"], ROW["noise_gain"])
    law_rows, after, ceiling = (ROW["nominal"], ROW["halvings"]), (force, amplitude, friction_row), ROW["max_amplitude"]

    def lifted(d_step: int, d_lane: int) -> Any:
        """Disturbance of node j, lane i at d[j * d_step + i * d_lane]: one column for all lanes, or one for each."""

        @compiled
        def plant(s, n, d, at, command, first):  # type: ignore[no-untyped-def]
            for i in range(count(n)):
                start, g = peek(s, amplitude * width + i), peek(s, friction_row * width + i)
                law = load(s, i, width, law_rows)
                held = limit_step(peek(s, command * width + i), peek(s, ceiling * width + i))
                # Two partial sums: a lane alone waits for the chain of additions.
                f_m = sensor_start(*load(s, i, width, sensor_rows)) if first == 0 else peek(s, force * width + i)
                f = g + peek(d, at + first * d_step + i * d_lane)
                rest = sensor_node(0.0, f, peek(s, (weight + first) * width + i) if first == 0 else 0.0)
                a = start
                for m in range(1, NODES):
                    j = first + m
                    a = lowpass_step(start, held, peek(s, (decay + j) * width + i))
                    g = friction_step(a, *law)
                    f, w = g + peek(d, at + j * d_step + i * d_lane), peek(s, (weight + j) * width + i)
                    if m % 2:
                        f_m = sensor_node(f_m, f, w)
                    else:
                        rest = sensor_node(rest, f, w)
                store(s, i, width, after, (f_m + rest, a, g))

        return plant

    one_column, one_each = lifted(BLOCK, 0), lifted(BLOCK * width, 1)

    @compiled
    def plant(s, n, d, k, shared, command, first):  # type: ignore[no-untyped-def]
        if shared:
            one_column(s, n, d, k, command, first)
        else:
            one_each(s, n, d, k * width, command, first)

    return plant
