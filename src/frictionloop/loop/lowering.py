"""From Systems to the numbers of a tile: every block's coefficients, one column per lane."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from frictionloop.control.lookup import lookup_table
from frictionloop.loop import signals
from frictionloop.loop.kernel import EXTERNAL, PI, Buffers, Options, buffers, ring_size
from frictionloop.loop.quadrature import (
    MAX_SEGMENTS,
    PLATE_PER_SEGMENT,
    segment_nodes,
    segment_weights,
    segments_needed,
)
from frictionloop.loop.slab import LANES, Slab
from frictionloop.parameters import Constant, LogSweep, Sine, Source, Steps, System
from frictionloop.physics.sources import Sampler, sampler, sweep_turns
from frictionloop.quantities import FrictionloopError

SETPOINT_STREAM, DISTURBANCE_STREAM = 1, 2
"""Streams of coloured noise; 0 is the sensor noise."""


@dataclass(frozen=True)
class Tile:
    """Lanes of one structure, ready for the kernel."""

    slab: Slab
    lanes: int
    options: Options
    buffers: Buffers
    setpoint: Callable[[int, int], np.ndarray]
    disturbance: Callable[[int, int], np.ndarray]


STRUCTURAL = ("kind", "rate_hz", "table_size", "delay_s", "plate.cutoff_hz")
"""Last words of the paths whose values decide which systems can share a tile."""


def structure(system: System) -> tuple[object, ...]:
    """Return what must be equal for two systems to share a tile."""
    c = system.controller
    return (
        system.setpoint.kind,
        system.disturbance.kind,
        c.rate_hz,
        c.model.table_size,
        *_segments(system),
        system.plate.kind,
        system.sensor.kind,
        c.kind,
    )


def _delay_periods(system: System) -> int:
    return math.floor(system.controller.delay_s * system.controller.rate_hz + 1e-9)


def _switch(system: System) -> float:
    """Return how long after the sample the command in force changes, in s; 0 when it changes at the sample."""
    c = system.controller
    rest = c.delay_s - _delay_periods(system) / c.rate_hz
    return rest if rest > 1e-9 / c.rate_hz else 0.0


def _segments(system: System) -> tuple[int, int]:
    """Return the segments of a period before and after the command changes, at least one in all."""
    plate, period, switch = system.plate.cutoff_hz, 1.0 / system.controller.rate_hz, _switch(system)
    before, after = segments_needed(plate, switch), segments_needed(plate, period - switch)
    if max(before, after) > MAX_SEGMENTS:
        most = PLATE_PER_SEGMENT * MAX_SEGMENTS * system.controller.rate_hz
        raise FrictionloopError(
            f"plate.cutoff_hz = {plate:g} Hz: must be at most {most:g} Hz at controller.rate_hz = "
            f"{system.controller.rate_hz:g} Hz (a faster envelope is over within the period and cannot be resolved)"
        )
    return before, after


def lower(
    systems: Sequence[System],
    seeds: Sequence[int],
    *,
    groups: int = 0,
    score_from: int = 0,
    recording: bool = False,
    external: bool = False,
) -> Tile:
    """Return the tile that runs these systems (one, or up to ``LANES`` of equal structure) with these seeds."""
    width = 1 if len(systems) == 1 else LANES
    # A tile is always full: lanes beyond the last system repeat it and are not read.
    systems = [*systems, *[systems[-1]] * (width - len(systems))]
    lane_seeds = np.array([*seeds, *[seeds[-1]] * (width - len(seeds))], dtype=np.uint64)
    slab = Slab(width)
    period = 1.0 / systems[0].controller.rate_hz
    switch = np.array([_switch(s) for s in systems])
    before, after = _segments(systems[0])
    nodes = _lower_plant(slab, systems, switch, period, before, after)
    table = _lower_controller(slab, systems)
    setpoint = _lower_signal(slab, "setpoint_signal", [s.setpoint for s in systems], True)
    one_grid = bool(np.all(switch == switch[0]))
    disturbance = _lower_signal(slab, "disturbance_signal", [s.disturbance for s in systems], one_grid)
    one_seed = bool(np.all(lane_seeds == lane_seeds[0]))
    rate = systems[0].controller.rate_hz
    setpoint_shared, take_setpoint = _sampling(
        [s.setpoint for s in systems], rate, lane_seeds, SETPOINT_STREAM, setpoint[1], one_seed
    )
    disturbance_shared, take_disturbance = _sampling(
        [s.disturbance for s in systems], rate, lane_seeds, DISTURBANCE_STREAM, disturbance[1], one_seed
    )
    slab.view("shift")[0] = slab.view("setpoint_signal")[0]
    ring = ring_size(max(s.controller.delay_s * rate for s in systems))
    options = Options(
        law=EXTERNAL if external else PI,
        segments=before + after,
        before=before,
        setpoint=setpoint[0],
        setpoint_shared=setpoint_shared,
        disturbance=disturbance[0],
        disturbance_shared=disturbance_shared,
        noise_shared=one_seed,
        groups=groups,
        score_from=score_from,
        recording=recording,
        table_size=systems[0].controller.model.table_size,
        ring_mask=ring - 1,
        dt=period,
    )
    return Tile(slab, width, options, buffers(width, ring, nodes, table, lane_seeds), take_setpoint, take_disturbance)


def _lower_plant(
    slab: Slab, systems: Sequence[System], switch: np.ndarray, period: float, before: int, after: int
) -> int:
    nominal = np.array([s.friction.nominal_n for s in systems])
    susceptibility = np.array([s.friction.susceptibility_per_um2 for s in systems])
    ceiling = np.array([s.plate.max_amplitude_um for s in systems])
    times, since = segment_nodes(switch, period, before, after)
    nodes = len(times)
    plate_hz = np.array([s.plate.cutoff_hz for s in systems])
    sensor_hz = np.array([s.sensor.cutoff_hz for s in systems])
    noise = np.array([s.sensor.noise_rms_n for s in systems])
    slab.view("nominal")[0] = slab.view("friction")[0] = nominal
    slab.view("halvings")[0] = susceptibility / math.log(2.0)
    slab.view("max_amplitude")[0] = ceiling
    slab.view("floor")[0] = nominal * np.exp(-susceptibility * ceiling**2)
    slab.view("node_time")[:nodes] = times
    slab.view("decay")[:nodes] = np.exp(-2 * np.pi * plate_hz * since)
    slab.view("weight")[:nodes] = segment_weights(sensor_hz, switch, period, before, after)
    sensor_decay = np.exp(-2 * np.pi * sensor_hz * period)
    slab.view("sensor_decay")[0] = sensor_decay
    slab.view("noise_gain")[0] = noise * (1 - sensor_decay)
    slab.view("delay_periods")[0] = [_delay_periods(s) for s in systems]
    return nodes


def _lower_controller(slab: Slab, systems: Sequence[System]) -> np.ndarray:
    models = [s.controller.model for s in systems]
    low = np.array([m.floor_n for m in models])
    high = np.array([m.nominal_n for m in models])
    size = models[0].table_size
    gains = slab.view("controller_gains")
    gains[0] = [s.controller.kp for s in systems]
    gains[1] = [s.controller.ki for s in systems]
    gains[2], gains[3] = low, high
    model = slab.view("model")
    model[0] = np.log2(high)
    model[1] = [math.log(2.0) / m.susceptibility_per_um2 for m in models]
    model[2] = low
    model[3] = (size - 1) / (high - low)
    model[4] = size - 2
    if size == 0:
        return np.zeros(0)
    return np.ascontiguousarray(np.array([lookup_table(m) for m in models]).T).ravel()


def _formula(source: Source) -> tuple[float, float, float, float]:
    if isinstance(source, Sine):
        return source.offset_n, source.amplitude_n, source.frequency_hz, 0.0
    if isinstance(source, LogSweep):
        return source.offset_n, source.amplitude_n, *sweep_turns(source)
    return getattr(source, "offset_n", 0.0), 0.0, 0.0, 0.0


def _lower_signal(slab: Slab, rows: str, sources: Sequence[Source], one_grid: bool) -> tuple[int, bool]:
    """Set the formula rows; return how the signal is made and whether all lanes have the same one."""
    slab.view(rows)[:] = np.array([_formula(s) for s in sources]).T
    shared = one_grid and all(s == sources[0] for s in sources)
    if isinstance(sources[0], (Constant, Sine)):
        return signals.SINE, shared
    if isinstance(sources[0], LogSweep):
        return signals.LOG_SWEEP, shared
    return signals.HELD if isinstance(sources[0], Steps) else signals.SAMPLED, shared


def _none(start: int, stop: int) -> np.ndarray:
    return np.zeros(0)


def _sampling(
    sources: Sequence[Source], rate_hz: float, seeds: np.ndarray, stream: int, shared: bool, one_seed: bool
) -> tuple[bool, Sampler]:
    """Return whether one column serves all lanes, and the sampler of shape (periods + 1, columns)."""
    if sampler_kind := sources[0].kind not in ("constant", "sine", "log_sweep"):
        shared = shared and (one_seed or sources[0].kind != "noise")
    if not sampler_kind:
        return shared, _none
    takes = [sampler(s, rate_hz, int(seed), stream) for s, seed in zip(sources, seeds, strict=True)][
        : 1 if shared else None
    ]
    return shared, lambda start, stop: np.ascontiguousarray(
        np.array([take(start, stop) for take in takes if take]).T
    ).ravel()
