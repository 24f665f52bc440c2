"""Set-point, disturbance and noise for one block of control periods, made inside the kernel.

Buffers hold ``[node][period of the block][lane]``; a signal that is the same for all lanes of a tile is computed once,
with one column. Smooth signals are evaluated exactly at every node, sampled ones are linear between samples or held.
"""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles, load, peek, poke
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import exp2, fma, sin_turns, step
from frictionloop.quantities.normals import BLOCK


@step
def sine_step(t: float, offset: float, amplitude: float, frequency_hz: float, _unused: float) -> float:
    """offset + amplitude sin(2 pi f t)."""
    return fma(amplitude, sin_turns(frequency_hz * t), offset)


@step
def log_sweep_step(t: float, offset: float, amplitude: float, turns: float, octaves_per_s: float) -> float:
    """offset + amplitude sin(2 pi turns (2^(octaves_per_s t) - 1)), turns = f1 T / ln(f2/f1)."""
    return fma(amplitude, sin_turns(turns * (exp2(octaves_per_s, t) - 1.0)), offset)


FORMULAS = {"sine": sine_step, "log_sweep": log_sweep_step}
"""Signals that a kernel makes from a formula; all others come as samples."""


def build_formula(lifting: Lifting, which: str, how: str) -> Any:
    """Return the tile that makes a signal from its formula; the set-point has one node, at the sample."""
    (width, compiled, _), node_time, formula = lifting, ROW["node_time"], FORMULAS[how]
    parameters, one_node = rows(f"{which}_signal"), which == "setpoint"

    @compiled
    def fill(s, n, first, periods, o):  # type: ignore[no-untyped-def]
        out = doubles(o.setpoint if one_node else o.disturbance)
        shared = o.setpoint_shared if one_node else o.disturbance_shared
        for j in range(1 if one_node else o.nodes):
            if shared:
                given = load(s, 0, width, parameters)
                since = peek(s, (node_time + j) * width)
                for k in range(BLOCK):
                    poke(out, j * BLOCK + k, formula(fma(float(first + k), o.dt, since), *given))
            else:
                for k in range(BLOCK):
                    for i in range(width):
                        t = fma(float(first + k), o.dt, peek(s, (node_time + j) * width + i))
                        poke(out, (j * BLOCK + k) * width + i, formula(t, *load(s, i, width, parameters)))

    return fill


def build_samples(lifting: Lifting, which: str, held: bool) -> Any:
    """Return the tile that takes a signal from its samples, linear between them or held."""
    (width, compiled, _), node_time, one_node = lifting, ROW["node_time"], which == "setpoint"

    @compiled
    def fill(s, n, first, periods, o):  # type: ignore[no-untyped-def]
        out = doubles(o.setpoint if one_node else o.disturbance)
        samples = doubles(o.setpoint_samples if one_node else o.disturbance_samples)
        columns = 1 if (o.setpoint_shared if one_node else o.disturbance_shared) else width
        start = first - o.chunk
        for j in range(1 if one_node else o.nodes):
            for k in range(min(BLOCK, periods)):
                for i in range(columns):
                    y0 = peek(samples, (start + k) * columns + i)
                    y1 = y0 if held else peek(samples, (start + k + 1) * columns + i)
                    fraction = peek(s, (node_time + j) * width + i) / o.dt
                    poke(out, (j * BLOCK + k) * columns + i, fma(fraction, y1 - y0, y0))

    return fill
