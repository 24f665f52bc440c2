"""The loop of the bench: skin and contact feed back inside a control period, so it advances by substeps."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.control.switch import CLOSING
from frictionloop.loop.kernel.bench_tile import build_bench
from frictionloop.loop.kernel.exchange import EXTERNAL, FIRMWARE, GIVEN, ORACLE, STILL, pointers
from frictionloop.loop.kernel.felt_tile import build_felt
from frictionloop.loop.kernel.fixed_tile import build_fixed
from frictionloop.loop.kernel.laws_tile import build_laws
from frictionloop.loop.kernel.motion_tile import build_motion, build_touch
from frictionloop.loop.kernel.noise_tile import NOISE_STREAM, build_noise
from frictionloop.loop.kernel.oracle_tile import build_oracle
from frictionloop.loop.kernel.pulse_tile import build_pulses
from frictionloop.loop.kernel.score_tile import PERCEPTION, STEPS, build_scores
from frictionloop.loop.kernel.signals import build_signals
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.slab_access import pointer
from frictionloop.loop.kernel.start_tile import build_start
from frictionloop.loop.kernel.step_tile import build_steps
from frictionloop.loop.kernel.suspension_tile import build_sensor
from frictionloop.loop.kernel.switch_tile import build_switch
from frictionloop.loop.kernel.tiles import BENCH_TRACES, build_delay, build_inputs, build_record, lifting
from frictionloop.loop.kernel.timing_tile import build_timing
from frictionloop.physics.tremor import NORMAL_STREAM, TANGENTIAL_STREAM
from frictionloop.quantities.normals import BLOCK
from frictionloop.sensing.touch import LOAD_STREAM, POSITION_STREAM

JITTER_STREAM, LOST_STREAM = 24, 25
"""Streams of the counter-based noise that make commands late and lose ticks."""
_DRAWN = (TANGENTIAL_STREAM, NORMAL_STREAM, POSITION_STREAM, LOAD_STREAM, JITTER_STREAM, LOST_STREAM)
_STREAMS = tuple(np.uint64(stream) for stream in _DRAWN)


def build_substeps(width: int) -> Any:
    """Return ``advance`` for tiles of this width."""
    lift = lifting("substeps", width)
    compiled = lift.compiled
    fill_signal, fill_noise = build_signals(lift), build_noise(lift)
    control, limits = build_laws(lift)
    prepare, tell_law = build_switch(lift, limits)
    apply_late, pulse, scores = build_delay(lift), build_pulses(lift), build_scores(lift, masked=True)
    record, spread = build_record(lift, BENCH_TRACES), build_inputs(lift)[0]
    take_over, go_on, begin, accept = build_motion(lift)
    follow = build_touch(lift)
    settle, tell = build_start(lift)
    suspend, read = build_sensor(lift)
    (finger, plant), (time_switch, keep, restore) = build_bench(lift, spread, suspend), build_timing(lift)
    oracle, fixed = build_oracle(lift, spread, finger), build_fixed(lift)
    felt, (begin_steps, passages) = build_felt(lift), build_steps(lift)
    setpoint, disturbance, normal, draws = ROW["setpoint"], ROW["disturbance"], ROW["normal"], ROW["draws"]
    tangential, across, position, load, jitter, lost = _STREAMS
    timing_draws = ROW["timing_draws"]

    @compiled
    def sense(s, n, k, at, o, b):  # type: ignore[no-untyped-def]
        spread(s, n, setpoint, b.setpoint, at, o.setpoint_shared)
        spread(s, n, disturbance, b.disturbance, at, o.disturbance_shared)
        spread(s, n, normal, b.normals, at, o.noise_shared)
        if o.moving != STILL:
            for stream in range(4):
                spread(s, n, draws + stream, b.draws, stream * BLOCK + at, o.noise_shared)
            if k == 0:
                begin(s, n, b.roughness)
            take_over(s, n)
        if o.irregular:
            spread(s, n, timing_draws, b.timing, at, o.noise_shared)
            spread(s, n, timing_draws + 1, b.timing, BLOCK + at, o.noise_shared)
            time_switch(s, n)
        if k == 0:
            settle(s, n, o.contact == 0)
            limits(s, n)
        # Also under a finger that the caller moves: from the next period on it may move by itself.
        if o.moving != STILL:
            go_on(s, n, (k + 1) * o.dt, b.roughness)
        tell(s, n, o.contact)
        read(s, n)
        if o.moving != STILL:
            follow(s, n)

    @compiled
    def decide(s, n, k, at, o, b):  # type: ignore[no-untyped-def]
        since = k - o.open_until
        switching = o.law > 0 and o.open_until > 0 and since <= CLOSING
        if switching:
            prepare(s, n, since, o.law)
        if o.irregular:
            keep(s, n)
        if o.law == ORACLE:
            oracle(s, n, k, at, o, b)
        elif o.law == FIRMWARE:
            fixed(s, n, o.core, b.core, o.core_words, b.core_given, o.irregular, since >= 0)
        else:
            control(s, n, o.law, o.dt, b.table, o.table_size)
            if switching:
                tell_law(s, n, since, o.law)
        if o.irregular:
            restore(s, n)

    @compiled
    def score(s, n, k, o, b, trace, trace_size):  # type: ignore[no-untyped-def]
        counts = k >= o.score_from
        if counts:
            scores(s, n, o.groups)
        if o.groups & PERCEPTION:
            felt(s, n, b.weighting, counts)
        if o.groups & STEPS:
            if k == 0:
                begin_steps(s, n)
            passages(s, n, counts)
        if o.recording:
            record(s, n, k, trace, trace_size)

    @compiled
    def move_on(s, n, k, o, b):  # type: ignore[no-untyped-def]
        apply_late(s, n, k, b.history, o.ring_mask)
        if o.pulsed:
            pulse(s, n)
        plant(s, n, k % BLOCK, o, b)

    @compiled
    def obey(s, n, k, o, b):  # type: ignore[no-untyped-def]
        if o.moving == GIVEN:
            accept(s, n, b.roughness)
        move_on(s, n, k, o, b)

    @compiled
    def fill_draws(b, o, first, counters):  # type: ignore[no-untyped-def]
        columns = BLOCK if o.noise_shared else BLOCK * width
        fill_noise(b.draws, 0, b.seeds, o.noise_shared, first, counters, tangential)
        fill_noise(b.draws, columns, b.seeds, o.noise_shared, first, counters, across)
        fill_noise(b.draws, 2 * columns, b.seeds, o.noise_shared, first, counters, position)
        fill_noise(b.draws, 3 * columns, b.seeds, o.noise_shared, first, counters, load)

    @compiled
    def fill_timing(b, o, first, counters):  # type: ignore[no-untyped-def]
        columns = BLOCK if o.noise_shared else BLOCK * width
        fill_noise(b.timing, 0, b.seeds, o.noise_shared, first, counters, jitter)
        fill_noise(b.timing, columns, b.seeds, o.noise_shared, first, counters, lost)

    @compiled
    def advance(slab, n, start, stop, o, buffers, setpoint_samples, disturbance_samples, chunk, trace):  # type: ignore[no-untyped-def]
        s, traces, b = pointer(slab), pointer(trace), pointers(buffers)
        r, d = pointer(setpoint_samples), pointer(disturbance_samples)
        counters, nodes = BLOCK // 4 if n > 0 else 0, o.segments + 1
        shared_r, shared_d, size = o.setpoint_shared, o.disturbance_shared, trace.size // len(BENCH_TRACES)
        k = start
        while k < stop:
            # A command from outside comes after the measurement: its period runs when the next sample is due.
            if o.law == EXTERNAL and k > 0:
                obey(s, n, k - 1, o, b)
            first = k // BLOCK * BLOCK
            end = min(stop, first + BLOCK)
            periods, entered = end - first, k
            fill_signal(b.setpoint, s, o.setpoint, True, shared_r, r, chunk, first, periods, 1, o.dt)
            fill_signal(b.disturbance, s, o.disturbance, False, shared_d, d, chunk, first, periods, nodes, o.dt)
            fill_noise(b.normals, 0, b.seeds, o.noise_shared, first, counters, NOISE_STREAM)
            if o.moving != STILL:
                fill_draws(b, o, first, counters)
            if o.irregular:
                fill_timing(b, o, first, counters)
            while k < end:
                if o.law == EXTERNAL and k > entered:
                    obey(s, n, k - 1, o, b)
                sense(s, n, k, k - first, o, b)
                if o.law != EXTERNAL:
                    decide(s, n, k, k - first, o, b)
                score(s, n, k, o, b, traces, size)
                if o.law != EXTERNAL:
                    move_on(s, n, k, o, b)
                k += 1

    return advance
