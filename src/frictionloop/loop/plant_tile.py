"""The tile of the plant: plate, friction law and sensor over a stretch of constant command."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.quadrature import NODES
from frictionloop.loop.slab import ROW
from frictionloop.loop.slab_access import load, peek, store
from frictionloop.loop.tiles import Lifting
from frictionloop.physics.friction import remaining_step
from frictionloop.physics.plate import limit_step, lowpass_step
from frictionloop.sensing.lowpass import sensor_node, sensor_start


def build_plant(lifting: Lifting) -> Any:
    """Lift plate, friction law and sensor over one segment of the period by quadrature (loop/quadrature.py).

    The number of nodes is a constant, so the loop over nodes unrolls and the loop over lanes vectorises. Inside, the
    amplitude is counted in the amplitude that halves friction, and the weights carry f0: two products less per node.
    The disturbance's share of the reading is already summed over the nodes.
    """
    width, compiled, count = lifting
    decay, friction_weight, weight = ROW["decay"], ROW["friction_weight"], ROW["weight"]
    force, friction_row, amplitude, driven = ROW["measurement"], ROW["friction"], ROW["amplitude"], ROW["driven"]
    sensor_rows = (force, ROW["normal"], ROW["sensor_decay"], ROW["noise_gain"])
    halving, nominal, ceiling = ROW["halving_amplitude"], ROW["nominal"], ROW["max_amplitude"]
    after = (force, amplitude, friction_row)

    @compiled
    def plant(s, n, command, first):  # type: ignore[no-untyped-def]
        for i in range(count(n)):
            unit, per_unit = peek(s, halving * width + i), peek(s, (halving + 1) * width + i)
            start = peek(s, amplitude * width + i) * per_unit
            held = limit_step(peek(s, command * width + i), peek(s, ceiling * width + i)) * per_unit
            # Two partial sums: a lane alone waits for the chain of additions.
            if first == 0:
                f_m = sensor_start(*load(s, i, width, sensor_rows)) + peek(s, driven * width + i)
                rest = sensor_node(0.0, peek(s, friction_row * width + i), peek(s, weight * width + i))
            else:
                f_m, rest = peek(s, force * width + i), 0.0
            y, remaining = start, 0.0
            for m in range(1, NODES):
                y = lowpass_step(start, held, peek(s, (decay + first + m) * width + i))
                remaining = remaining_step(y)
                w = peek(s, (friction_weight + first + m) * width + i)
                if m % 2:
                    f_m = sensor_node(f_m, remaining, w)
                else:
                    rest = sensor_node(rest, remaining, w)
            g = peek(s, nominal * width + i) * remaining
            store(s, i, width, after, (f_m + rest, y * unit, g))

    return plant
