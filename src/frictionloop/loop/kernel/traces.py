"""What a run records of each period, and the parts of tiles that move numbers from one row to another."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import doubles, peek, poke
from frictionloop.loop.kernel.slab import ROW, rows
from frictionloop.loop.kernel.tiles import Lifting

TRACES = ("f_r", "f_a", "f_m", "u", "a", "d", "saturated")
BENCH_TRACES = (*TRACES, "position", "speed", "load", "limit", "floor", "sliding", "scored")
"""Traces of the two kernels, in the order of their rows."""
_BENCH_ROWS = (*rows("motion")[:3], ROW["nominal"], ROW["floor"], ROW["measurement"] + 4, ROW["scored"])


def traces_of(kernel: str) -> tuple[str, ...]:
    """Return the names of the traces that a kernel records."""
    return TRACES if kernel == "quadrature" else BENCH_TRACES


def build_record(lifting: Lifting, kernel: str) -> Any:
    """Return the tile that writes the traces of one period, ``[trace][period][lane]``."""
    width, compiled, count = lifting
    force, u, sat, r, d = ROW["measurement"], ROW["u"], ROW["saturated"], ROW["setpoint"], ROW["disturbance"]
    amplitude, friction_row = ROW["amplitude"], ROW["friction"]
    more = len(traces_of(kernel)) > len(TRACES)

    @compiled
    def record(s, n, k, at, o):  # type: ignore[no-untyped-def]
        out, size = doubles(o.trace), o.trace_size
        for i in range(count(n)):
            at = k * width + i
            disturbance = peek(s, d * width + i)
            poke(out, at, peek(s, r * width + i))
            poke(out, size + at, peek(s, friction_row * width + i) + disturbance)
            poke(out, 2 * size + at, peek(s, force * width + i))
            poke(out, 3 * size + at, peek(s, u * width + i))
            poke(out, 4 * size + at, peek(s, amplitude * width + i))
            poke(out, 5 * size + at, disturbance)
            poke(out, 6 * size + at, peek(s, sat * width + i))
            if more:
                for j in range(len(_BENCH_ROWS)):
                    poke(out, (7 + j) * size + at, peek(s, _BENCH_ROWS[j] * width + i))

    return record


def lift_spread(lifting: Lifting) -> Any:
    """Return what brings a signal into its row."""
    width, compiled, count = lifting

    @compiled
    def spread(s, n, row, values, k, shared):  # type: ignore[no-untyped-def]
        if shared:
            value = peek(values, k)
            for i in range(count(n)):
                poke(s, row * width + i, value)
        else:
            for i in range(count(n)):
                poke(s, row * width + i, peek(values, k * width + i))

    return spread


def lift_delay(lifting: Lifting) -> Any:
    """Return what picks the commands in force during a period when they are applied later than the sample."""
    width, compiled, count = lifting
    command, applied, delay = ROW["command"], ROW["applied"], ROW["delay_periods"]

    @compiled
    def apply_late(s, n, k, o):  # type: ignore[no-untyped-def]
        history, mask = doubles(o.history), o.ring_mask
        for i in range(count(n)):
            poke(history, (k & mask) * width + i, peek(s, command * width + i))
            since = k - int(peek(s, delay * width + i))
            poke(s, (applied + 1) * width + i, peek(history, (since & mask) * width + i))
            poke(s, applied * width + i, peek(history, ((since - 1) & mask) * width + i))

    return apply_late
