"""What Python and a compiled kernel exchange: the options all lanes of a tile share, scratch and history."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from frictionloop.loop.kernel.slab import aligned
from frictionloop.loop.kernel.slab_access import pointer
from frictionloop.quantities.arithmetic import step
from frictionloop.quantities.normals import BLOCK

NOTHING, NO_WORDS = np.zeros(0), np.zeros(0, np.int32)
FIRMWARE, ORACLE, EXTERNAL, PI = -2, -1, 0, 1
"""Who commands: the C core, the oracle, the caller (``Stepper``), or the control law of this number (control/laws)."""
STILL, STROKES, GIVEN = 0, 1, 2
"""Who moves the finger: nobody, its strokes, or the caller."""
CORE_GIVEN, CORE_TOLD = 7, 3
"""Numbers to the C core in a tick (measurement, set-point, 1 unless open), and back (u, saturated, amplitude)."""
CONTACTS = ("rigid", "dahl", "lugre", "slider")
"""Contact laws of the kernel."""


class Plan(NamedTuple):
    """How an oracle looks ahead (loop/kernel/oracle_tile)."""

    preview: bool = False
    late: int = 0
    """Whole periods of the delay."""
    predicted: int = 0
    """Substeps until its command takes effect."""
    steps: int = 1
    """Steps of a trial per period."""
    landing: int = 1
    """Periods of a trial after that of the command tried, in which the amplitude goes where it has to stay."""
    trials: int = 1


class Options(NamedTuple):
    """What all lanes of a tile share: the structure of the loop and how its signals are made."""

    law: int
    """ORACLE, EXTERNAL or the number of a control law."""
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
    moving: int
    """STILL, STROKES or GIVEN."""
    irregular: bool
    """Commands come late by chance, or ticks are lost."""
    contact: int
    """Number of the contact law in ``CONTACTS``."""
    plan: Plan
    """Of an oracle."""
    pulsed: bool = False
    """The carrier is made of pulses of whole ticks."""
    core: int = 0
    """Address of the C core's function."""
    core_words: int = 0
    """Words of the C core per lane."""
    open_until: int = 0
    """Period with which the loop closes; 0: it is closed from the start."""


class Buffers(NamedTuple):
    """Scratch and history of one tile."""

    setpoint: np.ndarray
    disturbance: np.ndarray
    driven: np.ndarray
    normals: np.ndarray
    history: np.ndarray
    table: np.ndarray
    seeds: np.ndarray
    draws: np.ndarray
    """Unit normals of tremor, position and load, one block after the other."""
    roughness: np.ndarray
    """Table of n(x), ``[cell][lane]``."""
    timing: np.ndarray
    """Unit normals of jitter and of lost ticks, one block after the other."""
    weighting: np.ndarray
    """Coefficients of the perceptual weighting filter, five a section."""
    core: np.ndarray
    """Words and state of the C core, lane by lane."""
    core_given: np.ndarray
    """What the C core is given and tells."""


@step
def pointers(buffers: Any) -> Any:
    """Return the addresses of the arrays, which have no reference counts (compiled code only)."""
    return Buffers(
        pointer(buffers.setpoint),
        pointer(buffers.disturbance),
        pointer(buffers.driven),
        pointer(buffers.normals),
        pointer(buffers.history),
        pointer(buffers.table),
        pointer(buffers.seeds),
        pointer(buffers.draws),
        pointer(buffers.roughness),
        pointer(buffers.timing),
        pointer(buffers.weighting),
        pointer(buffers.core),
        pointer(buffers.core_given),
    )


def ring_size(longest_delay: float) -> int:
    """Return the length of the command history: 1 without delay, else a power of two that holds two periods more."""
    return 1 << math.ceil(longest_delay + 1).bit_length() if longest_delay else 1


def buffers(
    width: int,
    ring: int,
    nodes: int,
    table: np.ndarray,
    seeds: np.ndarray,
    roughness: np.ndarray = NOTHING,
    weighting: np.ndarray = NOTHING,
    core: np.ndarray = NO_WORDS,
) -> Buffers:
    """Return zeroed scratch and history for one tile."""
    return Buffers(
        setpoint=aligned(BLOCK * width),
        disturbance=aligned(nodes * BLOCK * width),
        driven=aligned(BLOCK * width),
        normals=aligned(BLOCK * width),
        history=aligned(ring * width),
        table=table,
        seeds=seeds,
        draws=aligned(4 * BLOCK * width if roughness.size else 0),
        roughness=roughness,
        timing=aligned(2 * BLOCK * width),
        weighting=weighting,
        core=core,
        core_given=aligned(CORE_GIVEN + CORE_TOLD),
    )
