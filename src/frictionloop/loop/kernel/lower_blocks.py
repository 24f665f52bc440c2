"""From the blocks of Systems to numbers: signals, a period of plate and sensor, a bench with its finger."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtri

from frictionloop.loop.kernel.endpoint_quadrature import TERMS, segment_ends
from frictionloop.loop.kernel.period_quadrature import segment_nodes, segment_weights
from frictionloop.loop.kernel.signal_generation import FORMULAS
from frictionloop.loop.kernel.slab import SEGMENT_ROWS
from frictionloop.loop.kernel.slab_columns import Slab, column
from frictionloop.loop.kernel.tile_compatibility import moves, substeps_of, switch_s
from frictionloop.parameters import (
    ColouredNoise,
    Constant,
    FingerFriction,
    LogSweep,
    Sine,
    Skin,
    Source,
    Steps,
    Strokes,
    System,
)
from frictionloop.physics.bristle_contact import ContactCoefficients, contact_coefficients
from frictionloop.physics.finger_step import Motion
from frictionloop.physics.limit_scaling import ageing_coefficients, limit_coefficients, occlusion_coefficients
from frictionloop.physics.motion import load_plan, scored_edge_m, stroke_plan
from frictionloop.physics.plate import plate_coefficients
from frictionloop.physics.roughness import cells_per_m, roughness_table
from frictionloop.physics.signal_values import Sampler, sampler, sweep_turns
from frictionloop.physics.tremor import tremor_coefficients, tremor_start
from frictionloop.rendering.effect_program import START
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.sensing.finger_tracking import touch_coefficients
from frictionloop.sensing.force_sensor import converter, noise_coefficients, suspension_coefficients

_HOW = {Constant: "sine", Sine: "sine", LogSweep: "log_sweep", Steps: "held"}
"""How signals are made; all others are linear between samples."""


class Signal(NamedTuple):
    """How the kernel makes a signal."""

    how: str
    """A formula of `FORMULAS` (signals), or how samples are taken: "linear" or "held"."""
    shared: bool
    """One column serves all lanes."""
    take: Sampler
    """(start, stop) -> samples of a chunk, [period][column], empty for a formula."""


def lower_signal(
    slab: Slab, rows: str, sources: Sequence[Source], seeds: np.ndarray, stream: int, rate_hz: float, nodes_alike: bool
) -> Signal:
    """Set the formula rows of a signal, one source per lane; ``nodes_alike`` says that lanes may share it."""
    first = sources[0]
    if isinstance(first, EffectSource):  # made tick by tick (loop/kernel/foreign_tile)
        return Signal("effect", False, lambda start, stop: np.zeros(0))
    alike = all(s is first or s == first for s in sources)
    slab.view(rows)[:] = np.array([_formula(s) for s in (sources[:1] if alike else sources)]).T
    drawn = isinstance(first, ColouredNoise) and bool(np.any(seeds != seeds[0]))
    shared = nodes_alike and alike and not drawn
    how = _HOW.get(type(first), "linear")
    sampled = [] if how in FORMULAS else sources[: 1 if shared else len(sources)]
    takes = [sampler(s, rate_hz, int(seed), stream) for s, seed in zip(sampled, seeds, strict=False)]

    def take(start: int, stop: int) -> np.ndarray:
        return np.ascontiguousarray(np.array([one(start, stop) for one in takes if one]).T).ravel()

    return Signal(how, shared, take)


def _formula(source: Source) -> tuple[float, float, float, float]:
    if isinstance(source, Sine):
        return source.offset_n, source.amplitude_n, source.frequency_hz, 0.0
    if isinstance(source, LogSweep):
        return source.offset_n, source.amplitude_n, *sweep_turns(source)
    return getattr(source, "offset_n", 0.0), 0.0, 0.0, 0.0


def lower_plant(slab: Slab, systems: Sequence[System], switch_s: np.ndarray, before: int, after: int) -> int:
    """Set the rows of plate and sensor, for periods of so many segments; return the nodes of a period."""
    period = 1.0 / systems[0].controller.rate_hz
    plate_hz = column([s.plate for s in systems], lambda plate: plate.cutoff_hz)
    sensor_hz, noise = column([s.sensor for s in systems], lambda sensor: (sensor.cutoff_hz, sensor.noise_rms_n))
    plants = np.broadcast(plate_hz, sensor_hz, switch_s)
    rows = np.array([period_rows(*map(float, plant), period, before, after) for plant in plants]).T
    segments = (before + after) * SEGMENT_ROWS
    nodes = (len(rows) - segments - 1) // 2
    slab.view("node_time")[:nodes] = rows[:nodes]
    slab.view("weight")[:nodes] = rows[nodes : 2 * nodes]
    slab.view("segment")[:segments] = rows[2 * nodes : -1]
    of_ends = slab.view("segment").reshape(-1, SEGMENT_ROWS, slab.width)[: before + after, 1 + TERMS :]
    of_ends *= slab.view("nominal")[0]  # the end's friction is counted in f0
    slab.view("sensor_decay")[0] = rows[-1]
    slab.view("noise_gain")[0] = noise * (1.0 - rows[-1])
    return nodes


@lru_cache(maxsize=4096)
def period_rows(
    plate_hz: float, sensor_hz: float, switch_s: float, period_s: float, before: int, after: int
) -> np.ndarray:
    """Return node times, their weights, each segment's decay and terms of both ends, and the sensor's decay.

    One plant at a time: sums over arrays of lanes would round differently in a tile and alone.
    """
    times = segment_nodes(switch_s, period_s, before, after)
    weights = segment_weights(sensor_hz, switch_s, period_s, before, after)
    decay, ends = segment_ends(plate_hz, sensor_hz, switch_s, period_s, before, after)
    segments = np.concatenate([decay[:, None], ends.reshape(len(decay), 2 * TERMS)], axis=1)
    return np.concatenate([times, weights, segments.ravel(), [math.exp(-2.0 * math.pi * sensor_hz * period_s)]])


def lower_swing(slab: Slab, nodes: int) -> None:
    """Set what a sine of the disturbance adds to the reading: its sum over the nodes, by the addition theorem."""
    offset, amplitude, frequency_hz, _ = slab.view("disturbance_signal")
    weight = slab.view("weight")[:nodes]
    turn = 2.0 * np.pi * frequency_hz * slab.view("node_time")[:nodes]
    shares = np.stack([weight * offset, weight * amplitude * np.cos(turn), weight * amplitude * np.sin(turn)])
    slab.view("swing")[:] = np.cumsum(shares, axis=1)[:, -1]  # one node after the other: the same bits for any width


_PERSON = 0x9E3779B97F4A7C15
"""2^64 over the golden ratio, odd: people with numbers 0, 1, ... get keys that are far apart."""
_PLAIN = FingerFriction(load_exponent=0.0, occlusion_ratio=1.0, moist_loss=0.0, roughness_rms=0.0)
"""A friction limit that depends on nothing: equation (1) under a finger that moves."""
_STILL = Motion(0.0, 0.0, 0.0, factor=1.0, occluded=0.0, direction=1.0, place=0.0)
"""A finger of which the loop asks nothing."""


def keys_of(systems: Sequence[System], seeds: Sequence[int]) -> np.ndarray:
    """Return the key of each lane's noise: the seed, moved on by the person's number."""
    people = column([s.motion for s in systems], lambda motion: motion.person if isinstance(motion, Strokes) else 0)
    return np.array(seeds, np.uint64) + np.uint64(_PERSON) * people.astype(np.uint64)  # modulo 2^64


class Lane(NamedTuple):
    """What the numbers of a lane are worked out from."""

    system: System
    key: int
    """Of its noise."""
    period_s: float
    substep_s: float


def lower_bench(slab: Slab, systems: Sequence[System], keys: np.ndarray) -> np.ndarray:
    """Set the rows of finger, motion and sensor, one system per lane; return the tables of roughness."""
    period_s, substeps = 1.0 / systems[0].controller.rate_hz, substeps_of(systems[0])
    h = period_s / substeps
    slab.view("node_time")[1 : 1 + substeps] = (h * (np.arange(substeps) + 0.5))[:, None]
    lanes = [Lane(system, int(key), period_s, h) for system, key in zip(systems, keys, strict=True)]
    slab.fill(_plant, lanes)
    if not moves(systems[0]):
        slab.fill(lambda _: dict.fromkeys(("motion", "motion_next"), _STILL), lanes[:1])
        return np.zeros(0)
    slab.fill(_motion, lanes)
    if isinstance(systems[0].setpoint, EffectSource):
        slab.fill(_effect, lanes)
    tables = [roughness_table(_friction(lane.system).roughness_rms, lane.key) for lane in lanes]
    return np.ascontiguousarray(np.array(tables).T).ravel()


def _plant(lane: Lane) -> dict[str, Any]:
    s, h = lane.system, lane.substep_s
    late, jitter = switch_s(s) * s.controller.rate_hz, s.controller.jitter_s * s.controller.rate_hz
    lost_below = float(ndtri(s.controller.lost_ticks)) if s.controller.lost_ticks else -math.inf
    return {
        "limit_n": s.friction.nominal_n,
        "plate_coefficients": plate_coefficients(s.plate, h),
        "contact_coefficients": contact_of_step(s, h),
        "compliance": 1.0 / s.finger.stiffness_n_m if isinstance(s.finger, Skin) else 0.0,
        "suspension_coefficients": suspension_coefficients(s.sensor, h),
        "timing": (late, jitter, lost_below),
        "switch": late,
        "noise_coefficients": noise_coefficients(s.sensor, lane.period_s),
        "converter": converter(s.sensor),
    }


def _effect(lane: Lane) -> dict[str, Any]:
    setpoint = lane.system.setpoint
    predicted = isinstance(setpoint, EffectSource) and setpoint.position == "predicted"
    lead_s = lane.system.controller.delay_s + 0.5 * lane.period_s
    return {"effect_seen": START, "effect_true": START, "effect_lead": lead_s if predicted else -1.0}


def _motion(lane: Lane) -> dict[str, Any]:
    motion, friction, dt = lane.system.motion, _friction(lane.system), lane.period_s
    assert isinstance(motion, Strokes)
    shape = motion.tremor_hz, motion.tremor_width_hz, dt
    along, across = (tremor_coefficients(rms, *shape) for rms in (1e-6 * motion.tremor_um, motion.tremor_n))
    return {
        "stroke_plan": stroke_plan(motion),
        "load_plan": load_plan(motion, lane.key),
        "tremor_along_coefficients": along,
        "tremor_across_coefficients": across,
        "tremor_along": tremor_start(along, lane.key, 0),
        "tremor_across": tremor_start(across, lane.key, 1),
        "limit_coefficients": limit_coefficients(friction),
        "occlusion_coefficients": occlusion_coefficients(friction, dt),
        "ageing": ageing_coefficients(friction),
        "roughness_per_m": cells_per_m(friction.roughness_longest_mm),
        "touch_coefficients": touch_coefficients(lane.system.touch, dt),
        "unscored": (scored_edge_m(motion, lane.system.finger), 0.5 * motion.load_n),
    }


def _friction(system: System) -> FingerFriction:
    return system.friction if isinstance(system.friction, FingerFriction) else _PLAIN


def contact_of_step(system: System, h: float) -> ContactCoefficients:
    """Return the coefficients of the contact for a step of h seconds."""
    skin = system.finger
    return contact_coefficients(skin, h) if isinstance(skin, Skin) else ContactCoefficients(h, *[0.0] * 7)
