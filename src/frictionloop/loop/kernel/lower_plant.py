"""From Systems to the numbers of a quadrature kernel: a period of plate and sensor, worked out once for each plant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from frictionloop.loop.kernel.columns import Slab, column
from frictionloop.loop.kernel.ends import TERMS, segment_ends
from frictionloop.loop.kernel.quadrature import segment_nodes, segment_weights
from frictionloop.loop.kernel.slab import SEGMENT_ROWS
from frictionloop.parameters import System


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
