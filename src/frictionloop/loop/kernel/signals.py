"""Set-point and disturbance for one block of control periods, made inside the kernel.

Buffers hold ``[node][period of the block][lane]``; a signal that is the same for all lanes of a tile is computed once,
with one column. Smooth signals are evaluated exactly at every node, sampled ones are linear between samples.
"""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.slab_access import load, peek, poke
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import exp2, fma, sin_turns, step
from frictionloop.quantities.normals import BLOCK

SINE, LOG_SWEEP, SAMPLED, HELD = range(4)
"""How a signal is made: from its formula, linear between samples, or held from sample to sample."""


@step
def sine_step(t: float, offset: float, amplitude: float, frequency_hz: float, _unused: float) -> float:
    """offset + amplitude sin(2 pi f t)."""
    return fma(amplitude, sin_turns(frequency_hz * t), offset)


@step
def log_sweep_step(t: float, offset: float, amplitude: float, turns: float, octaves_per_s: float) -> float:
    """offset + amplitude sin(2 pi turns (2^(octaves_per_s t) - 1)), turns = f1 T / ln(f2/f1)."""
    return fma(amplitude, sin_turns(turns * (exp2(octaves_per_s, t) - 1.0)), offset)


def build_signals(lifting: Lifting) -> Any:
    """Return the compiled ``fill_signal`` for the tiles of a kernel."""
    (width, compiled, _), node_time = lifting, ROW["node_time"]

    def filler(formula: Any) -> Any:
        @compiled
        def fill(out, s, parameters, shared, first, nodes, dt):  # type: ignore[no-untyped-def]
            for j in range(nodes):
                if shared:
                    given = load(s, 0, width, parameters)
                    since = peek(s, (node_time + j) * width)
                    for k in range(BLOCK):
                        poke(out, j * BLOCK + k, formula(fma(float(first + k), dt, since), *given))
                else:
                    for k in range(BLOCK):
                        for i in range(width):
                            t = fma(float(first + k), dt, peek(s, (node_time + j) * width + i))
                            poke(out, (j * BLOCK + k) * width + i, formula(t, *load(s, i, width, parameters)))

        return fill

    sine, sweep = filler(sine_step), filler(log_sweep_step)

    @compiled
    def fill_sampled(out, s, samples, start, periods, held, shared, nodes, dt):  # type: ignore[no-untyped-def]
        columns = 1 if shared else width
        for j in range(nodes):
            for k in range(min(BLOCK, periods)):
                for i in range(columns):
                    y0 = peek(samples, (start + k) * columns + i)
                    y1 = y0 if held else peek(samples, (start + k + 1) * columns + i)
                    fraction = peek(s, (node_time + j) * width + i) / dt
                    poke(out, (j * BLOCK + k) * columns + i, fma(fraction, y1 - y0, y0))

    setpoint_rows, disturbance_rows = rows("setpoint_signal"), rows("disturbance_signal")

    @compiled
    def fill_signal(out, s, kind, is_setpoint, shared, samples, chunk, first, periods, nodes, dt):  # type: ignore[no-untyped-def]
        if kind == SINE:
            sine(out, s, setpoint_rows if is_setpoint else disturbance_rows, shared, first, nodes, dt)
        elif kind == LOG_SWEEP:
            sweep(out, s, setpoint_rows if is_setpoint else disturbance_rows, shared, first, nodes, dt)
        else:
            fill_sampled(out, s, samples, first - chunk, periods, kind == HELD, shared, nodes, dt)

    return fill_signal
