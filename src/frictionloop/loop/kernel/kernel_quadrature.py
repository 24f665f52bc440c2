"""The loop of Section 2: nothing feeds back inside a control period, so one step takes all of it (kernel/ends.py)."""

from __future__ import annotations

from typing import Any

from frictionloop.control.laws import LAWS
from frictionloop.loop.kernel.control_tile import build_control
from frictionloop.loop.kernel.driven_tile import build_driven
from frictionloop.loop.kernel.exchange import PI, pointers
from frictionloop.loop.kernel.felt_tile import build_felt
from frictionloop.loop.kernel.noise_tile import NOISE_STREAM, build_noise
from frictionloop.loop.kernel.plant_tile import build_plant
from frictionloop.loop.kernel.quadrature import NODES
from frictionloop.loop.kernel.score_tile import PERCEPTION, STEPS, build_scores
from frictionloop.loop.kernel.signals import SINE, build_signals
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.slab_access import pointer
from frictionloop.loop.kernel.step_tile import build_steps
from frictionloop.loop.kernel.tiles import TRACES, build_delay, build_inputs, build_record, lifting
from frictionloop.quantities.normals import BLOCK


def build_quadrature(width: int) -> Any:
    """Return ``advance`` for tiles of this width."""
    blockwise, lift = lifting("quadrature", width), lifting("quadrature", width, inlined=True)
    fill_signal, fill_noise = build_signals(blockwise), build_noise(blockwise)
    fill_driven, fill_swing = build_driven(blockwise)
    pi, pi_limits = build_control(lift, LAWS[PI - 1])
    apply_late = build_delay(lift)
    plant = build_plant(lift)
    command, applied = ROW["command"], ROW["applied"]
    scores, record = build_scores(lift), build_record(lift)
    spread, settle = build_inputs(lift)
    felt, (begin_steps, passages) = build_felt(lift), build_steps(lift)
    setpoint, disturbance, normal = ROW["setpoint"], ROW["disturbance"], ROW["normal"]
    driven = ROW["driven"]

    @lift.compiled
    def one_period(s, n, k, at, o, b, trace, trace_size):  # type: ignore[no-untyped-def]
        spread(s, n, setpoint, b.setpoint, at, o.setpoint_shared)
        spread(s, n, disturbance, b.disturbance, at, o.disturbance_shared)
        spread(s, n, normal, b.normals, at, o.noise_shared)
        spread(s, n, driven, b.driven, at, o.disturbance_shared)
        if k == 0:
            settle(s, n)
            pi_limits(s, n)
        if o.law == PI:
            pi(s, n, PI, o.dt, b.table, o.table_size)
        if k >= o.score_from:
            scores(s, n, o.groups)
        if o.groups & PERCEPTION:
            felt(s, n, b.weighting, k >= o.score_from)
        if o.groups & STEPS:
            if k == 0:
                begin_steps(s, n)
            passages(s, n, k >= o.score_from)
        if o.recording:
            record(s, n, k, trace, trace_size)
        if o.ring_mask == 0 and o.segments == 1:
            plant(s, n, command, 0)
            return
        apply_late(s, n, k, b.history, o.ring_mask)
        for segment in range(o.segments):
            held = applied if segment < o.before else applied + 1
            plant(s, n, held, segment)

    @blockwise.compiled
    def advance(slab, n, start, stop, o, buffers, setpoint_samples, disturbance_samples, chunk, trace):  # type: ignore[no-untyped-def]
        s, traces = pointer(slab), pointer(trace)
        r_samples, d_samples = pointer(setpoint_samples), pointer(disturbance_samples)
        b = pointers(buffers)
        nodes = (NODES - 1) * o.segments + 1
        counters = BLOCK // 4 if n > 0 else 0
        k = start
        while k < stop:
            first = k // BLOCK * BLOCK
            end = min(stop, first + BLOCK)
            fill_signal(
                b.setpoint, s, o.setpoint, True, o.setpoint_shared, r_samples, chunk, first, end - first, 1, o.dt
            )
            if o.disturbance == SINE:
                fill_swing(b.disturbance, b.driven, s, o.disturbance_shared, first, o.dt)
            else:
                kind, shared = o.disturbance, o.disturbance_shared
                fill_signal(b.disturbance, s, kind, False, shared, d_samples, chunk, first, end - first, nodes, o.dt)
                fill_driven(b.driven, s, b.disturbance, shared, nodes, end - first)
            fill_noise(b.normals, 0, b.seeds, o.noise_shared, first, counters, NOISE_STREAM)
            while k < end:
                one_period(s, n, k, k - first, o, b, traces, trace.size // len(TRACES))
                k += 1

    return advance
