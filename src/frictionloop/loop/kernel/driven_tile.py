"""What the disturbance adds to the sensor's reading over each period of a block, ``[period of the block][lane]``."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles, load, peek, poke
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import cos_turns, fma, sin_turns
from frictionloop.quantities.normals import BLOCK


def build_swing(lifting: Lifting) -> Any:
    """Return the tile that makes a sine and its share of the reading at once."""
    width, compiled, _ = lifting
    swing_rows, sine_rows = rows("swing"), rows("disturbance_signal")

    @compiled
    def swing(out, driven, at, s, i, t):  # type: ignore[no-untyped-def]
        offset, amplitude, frequency_hz, _ = load(s, i, width, sine_rows)
        steady, in_phase, quarter = load(s, i, width, swing_rows)
        sine, cosine = sin_turns(frequency_hz * t), cos_turns(frequency_hz * t)
        poke(out, at, fma(amplitude, sine, offset))
        poke(driven, at, fma(in_phase, sine, fma(quarter, cosine, steady)))

    @compiled
    def fill_swing(s, n, first, periods, o):  # type: ignore[no-untyped-def]
        # What a sine adds to the reading is a sine: two evaluations where a sum over the nodes takes six.
        out, driven = doubles(o.disturbance), doubles(o.driven)
        for k in range(BLOCK):
            if o.disturbance_shared:
                swing(out, driven, k, s, 0, float(first + k) * o.dt)
            else:
                for i in range(width):
                    swing(out, driven, k * width + i, s, i, float(first + k) * o.dt)

    return fill_swing


def build_driven(lifting: Lifting) -> Any:
    """Return the tile that sums the disturbance's share of the reading over the nodes of each period."""
    (width, compiled, _), weight = lifting, ROW["weight"]

    @compiled
    def fill_driven(s, n, first, periods, o):  # type: ignore[no-untyped-def]
        out, d = doubles(o.driven), doubles(o.disturbance)
        columns = 1 if o.disturbance_shared else width
        for k in range(periods * columns):
            poke(out, k, 0.0)
        for j in range(o.nodes):
            if o.disturbance_shared:
                w = peek(s, (weight + j) * width)
                for k in range(periods):
                    poke(out, k, fma(w, peek(d, j * BLOCK + k), peek(out, k)))
            else:
                for k in range(periods):
                    for i in range(width):
                        f = peek(d, (j * BLOCK + k) * width + i)
                        poke(out, k * width + i, fma(peek(s, (weight + j) * width + i), f, peek(out, k * width + i)))

    return fill_driven
