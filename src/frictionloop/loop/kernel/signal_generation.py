"""Set-point, disturbance and noise for one block of control periods, made inside the kernel.

Buffers hold ``[node][period of the block][column]``: a column for each lane, or one for all lanes of a signal that is
``common`` to them. Smooth signals are evaluated exactly at every node, sampled ones are linear between samples or held.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.slab_access import doubles, keys, load, store
from frictionloop.loop.kernel.step_lifting import Lifting
from frictionloop.physics.tremor import NORMAL_STREAM, TANGENTIAL_STREAM
from frictionloop.quantities.counter_noise import BLOCK, box_muller, draw_words
from frictionloop.quantities.scalar_math import bits, cos_turns, double, exp2, fma, sin_turns, step
from frictionloop.sensing.finger_tracking import LOAD_STREAM, POSITION_STREAM


@step
def sine_step(t: float, offset: float, amplitude: float, frequency_hz: float, _unused: float) -> float:
    """offset + amplitude sin(2 pi f t)."""
    return fma(amplitude, sin_turns(frequency_hz * t), offset)


@step
def log_sweep_step(t: float, offset: float, amplitude: float, turns: float, octaves_per_s: float) -> float:
    """offset + amplitude sin(2 pi turns (2^(octaves_per_s t) - 1)), turns = f1 T / ln(f2/f1)."""
    return fma(amplitude, sin_turns(turns * (exp2(octaves_per_s, t) - 1.0)), offset)


@step
def swing_step(
    t: float, signal: tuple[float, float, float, float], steady: float, in_phase: float, quarter: float
) -> float:
    """What a sine adds to the reading, a sine again: two evaluations where a sum over the nodes takes six."""
    turns = signal[2] * t
    return fma(in_phase, sin_turns(turns), fma(quarter, cos_turns(turns), steady))


FORMULAS = {"sine": sine_step, "log_sweep": log_sweep_step}
"""Signals that a kernel makes from a formula; all others come as samples."""
JITTER_STREAM, LOST_STREAM = 24, 25
"""Streams of the counter-based noise that make commands late and lose ticks."""
STREAMS = {
    "normals": (0,),  # of the sensor
    "draws": (TANGENTIAL_STREAM, NORMAL_STREAM, POSITION_STREAM, LOAD_STREAM),
    "timing": (JITTER_STREAM, LOST_STREAM),
}
"""What is drawn, by the buffer that it goes to: one stream after another."""
_TIME, _WEIGHT = ROW["node_time"][0], ROW["weight"][0]


def build_signal(lifting: Lifting, which: str, how: str, common: bool, nodes: bool) -> Any:
    """Return the tile that makes a signal from formula or samples, at all ``nodes`` of a period or at its sample alone.

    ``which`` may be "driven" too: of a sine, what it adds to the reading over a period.
    """
    compiled, columns, smooth = lifting.compiled, 1 if common else lifting.width, how in FORMULAS
    setpoint, driven = which == "setpoint", which == "driven"
    given = (ROW["disturbance_signal"], *ROW["swing"]) if driven else ROW[f"{which}_signal"]
    if smooth:
        value = _lift_formula(lifting, swing_step if driven else FORMULAS[how], given)
    else:
        value = _lift_samples(lifting, setpoint, how == "held", columns)

    @compiled
    def fill(s, n, first, periods, o):  # type: ignore[no-untyped-def]
        out = doubles(o.setpoint if setpoint else (o.driven if driven else o.disturbance))
        for j in range(o.nodes if nodes else 1):
            for k in range(BLOCK if smooth else min(BLOCK, periods)):
                for i in range(columns):
                    store(out, i, columns, j * BLOCK + k, value(s, i, j, first + k, o))

    return fill


def _lift_formula(lifting: Lifting, formula: Any, given: Any) -> Any:
    """Return ``value(s, i, j, k, o)``: a formula in lane i at node j of period k."""
    width = lifting.width

    @lifting.compiled
    def value(s, i, j, k, o):  # type: ignore[no-untyped-def]
        return formula(fma(float(k), o.dt, load(s, i, width, _TIME + j)), *load(s, i, width, given))

    return value


def _lift_samples(lifting: Lifting, setpoint: bool, held: bool, columns: int) -> Any:
    """Return the same of samples, linear between them or held."""
    width = lifting.width

    @lifting.compiled
    def value(s, i, j, k, o):  # type: ignore[no-untyped-def]
        samples = doubles(o.setpoint_samples if setpoint else o.disturbance_samples)
        y0 = load(samples, i, columns, k - o.chunk)
        y1 = y0 if held else load(samples, i, columns, k - o.chunk + 1)
        return fma(load(s, i, width, _TIME + j) / o.dt, y1 - y0, y0)

    return value


def build_driven(lifting: Lifting, common: bool) -> Any:
    """Return the tile that sums what the disturbance adds to the reading over the nodes of each period."""
    (width, compiled, _), columns = lifting, 1 if common else lifting.width

    @compiled
    def fill(s, n, first, periods, o):  # type: ignore[no-untyped-def]
        out, d = doubles(o.driven), doubles(o.disturbance)
        for k in range(periods * columns):
            store(out, k, 1, 0, 0.0)
        for j in range(o.nodes):
            for k in range(periods):
                for i in range(columns):
                    force = load(d, i, columns, j * BLOCK + k)
                    added = fma(load(s, i, width, _WEIGHT + j), force, load(out, i, columns, k))
                    store(out, i, columns, k, added)

    return fill


def build_draws(lifting: Lifting, buffer: str, common: bool) -> Any:
    """Return the tile that draws the unit normals of all streams of a buffer."""
    compiled, columns = lifting.compiled, 1 if common else lifting.width
    streams = tuple(np.uint64(stream) for stream in STREAMS[buffer])
    sensor, moving = buffer == "normals", buffer == "draws"

    @compiled
    def scatter(out, at, apart, words):  # type: ignore[no-untyped-def]
        for j in range(4):
            store(out, at, apart, j, double(np.int64(words[j])))

    @compiled
    def fill_noise(out, at, seeds, first, counters, stream):  # type: ignore[no-untyped-def]
        # ``counters`` is always BLOCK // 4, but as a constant the loop would be unrolled instead of vectorised.
        # First all words, then all normals: in one loop the processor would see too little of either ahead.
        base, apart = first // BLOCK * counters, 8 * columns
        for c in range(counters):
            for i in range(columns):
                scatter(out, at + c * columns + i, apart, draw_words(load(seeds, i, 1, 0), stream, np.uint64(base + c)))
        for half in range(2):
            begin = at + 2 * half * apart
            for j in range(counters * columns):
                w0, w1 = load(out, begin + j, apart, (0, 1))
                store(out, begin + j, apart, (0, 1), box_muller(np.uint64(bits(w0)), np.uint64(bits(w1))))

    @compiled
    def draws(s, n, first, periods, o):  # type: ignore[no-untyped-def]
        out = doubles(o.normals if sensor else (o.draws if moving else o.timing))
        counters = BLOCK // 4 if n > 0 else 0
        for j in range(len(streams)):
            fill_noise(out, j * BLOCK * columns, keys(o.seeds), first, counters, streams[j])

    return draws


def lift_spread(lifting: Lifting) -> Any:
    """Return what brings a signal into its row."""
    width, compiled, count = lifting

    @compiled
    def spread(s, n, row, values, k, common):  # type: ignore[no-untyped-def]
        if common:
            value = load(values, 0, 1, k)
            for i in range(count(n)):
                store(s, i, width, row, value)
        else:
            for i in range(count(n)):
                store(s, i, width, row, load(values, i, width, k))

    return spread
