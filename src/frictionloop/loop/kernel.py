"""The compiled loop: steps of all rooms composed into one control period, the period repeated over time.

``advance`` is compiled for tiles of 32 lanes and for a single lane. It is single-threaded, releases the GIL and is
called for chunks of time, so that threads, Ctrl-C and progress belong to the caller.
"""

from __future__ import annotations

import math
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from frictionloop.control.pi import PiGains, PiState, pi_step
from frictionloop.loop.control_tile import build_control
from frictionloop.loop.kernel_cache import KernelCache
from frictionloop.loop.plant_tile import build_plant
from frictionloop.loop.quadrature import NODES
from frictionloop.loop.score_tile import build_scores
from frictionloop.loop.signals import build_signals
from frictionloop.loop.slab import ROW, ROWS, aligned, pointer
from frictionloop.loop.tiles import TRACES, build_delay, build_inputs, build_record, compiled_for
from frictionloop.quantities.normals import BLOCK

EXTERNAL, PI = 0, 1
"""Who commands: the caller (``Stepper``) or a control law of the kernel."""


class Options(NamedTuple):
    """What all lanes of a tile share: the structure of the loop and how its signals are made."""

    law: int
    segments: int
    before: int
    setpoint: int
    setpoint_shared: bool
    disturbance: int
    disturbance_shared: bool
    noise_shared: bool
    groups: int
    score_from: int
    recording: bool
    table_size: int
    ring_mask: int
    dt: float


class Buffers(NamedTuple):
    """Scratch and history of one tile."""

    setpoint: np.ndarray
    disturbance: np.ndarray
    driven: np.ndarray
    normals: np.ndarray
    history: np.ndarray
    table: np.ndarray
    seeds: np.ndarray


def _build(width: int) -> Any:
    compiled = compiled_for(width)
    fill_signal, fill_driven, fill_noise = build_signals(width)
    pi, pi_limits = build_control(width, pi_step, len(PiState._fields), len(PiGains._fields))
    apply_late = build_delay(width)
    plant = build_plant(width)
    command, applied = ROW["command"], ROW["applied"]
    scores, record = build_scores(width), build_record(width)
    spread, settle = build_inputs(width)
    setpoint, disturbance, normal = ROW["setpoint"], ROW["disturbance"], ROW["normal"]
    driven = ROW["driven"]

    @compiled
    def one_period(s, n, k, at, o, b, trace, trace_size):  # type: ignore[no-untyped-def]
        spread(s, n, setpoint, b.setpoint, at, o.setpoint_shared)
        spread(s, n, disturbance, b.disturbance, at, o.disturbance_shared)
        spread(s, n, normal, b.normals, at, o.noise_shared)
        spread(s, n, driven, b.driven, at, o.disturbance_shared)
        if k == 0:
            settle(s, n)
            pi_limits(s, n)
        if o.law == PI:
            pi(s, n, o.dt, b.table, o.table_size)
        if k >= o.score_from:
            scores(s, n, o.groups)
        if o.recording:
            record(s, n, k, trace, trace_size)
        if o.ring_mask == 0 and o.segments == 1:
            plant(s, n, command, 0)
            return
        apply_late(s, n, k, b.history, o.ring_mask)
        for segment in range(o.segments):
            held = applied if segment < o.before else applied + 1
            plant(s, n, held, segment * (NODES - 1))

    @compiled
    def advance(slab, n, start, stop, o, buffers, setpoint_samples, disturbance_samples, chunk, trace):  # type: ignore[no-untyped-def]
        s, traces = pointer(slab), pointer(trace)
        r_samples, d_samples = pointer(setpoint_samples), pointer(disturbance_samples)
        b = Buffers(
            pointer(buffers.setpoint),
            pointer(buffers.disturbance),
            pointer(buffers.driven),
            pointer(buffers.normals),
            pointer(buffers.history),
            pointer(buffers.table),
            pointer(buffers.seeds),
        )
        nodes = (NODES - 1) * o.segments + 1
        counters = BLOCK // 4 if n > 0 else 0
        k = start
        while k < stop:
            first = k // BLOCK * BLOCK
            end = min(stop, first + BLOCK)
            fill_signal(
                b.setpoint, s, o.setpoint, True, o.setpoint_shared, r_samples, chunk, first, end - first, 1, o.dt
            )
            fill_signal(
                b.disturbance,
                s,
                o.disturbance,
                False,
                o.disturbance_shared,
                d_samples,
                chunk,
                first,
                end - first,
                nodes,
                o.dt,
            )
            fill_driven(b.driven, s, b.disturbance, o.disturbance_shared, nodes, end - first)
            fill_noise(b.normals, b.seeds, o.noise_shared, first, counters)
            while k < end:
                one_period(s, n, k, k - first, o, b, traces, trace.size // len(TRACES))
                k += 1

    return advance


_kernels: dict[int, Any] = {}
_building = Lock()


def kernel(width: int) -> Any:
    """Return the compiled ``advance`` for tiles of this width (1 or ``LANES``), from the disk cache if it is there."""
    with _building:  # threads that start together must not compile it twice
        if width not in _kernels:
            advance = _build(width)
            advance._cache = KernelCache(advance.py_func, width)
            _call_once(advance, width)
            _kernels[width] = advance
        return _kernels[width]


def _call_once(advance: Any, width: int) -> None:
    """Compile or load the kernel by running it for no time at all, and let it never be compiled again.

    Numba does not guard the first call of a cached function: two threads would each load it, and the one that loses
    runs code that has been freed.
    """
    nothing, none = np.zeros(0), Options(EXTERNAL, 1, 0, 0, True, 0, True, True, 0, 0, False, 0, 0, 1.0)
    scratch = buffers(width, 1, 1, nothing, np.zeros(width, np.uint64))
    advance(aligned(ROWS * width), width, 0, 0, none, scratch, nothing, nothing, 0, nothing)
    advance.disable_compile()


def ring_size(longest_delay: float) -> int:
    """Return the length of the command history: 1 without delay, else a power of two that holds two periods more."""
    return 1 << math.ceil(longest_delay + 1).bit_length() if longest_delay else 1


def buffers(width: int, ring: int, nodes: int, table: np.ndarray, seeds: np.ndarray) -> Buffers:
    """Return zeroed scratch and history for one tile."""
    return Buffers(
        setpoint=aligned(BLOCK * width),
        disturbance=aligned(nodes * BLOCK * width),
        driven=aligned(BLOCK * width),
        normals=aligned(BLOCK * width),
        history=aligned(ring * width),
        table=table,
        seeds=seeds,
    )
