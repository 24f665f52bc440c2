"""What all lanes of a tile share, as one record: the structure of the loop, its tiles, scratch and history."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import from_dtype, types
from numba.extending import intrinsic

from frictionloop.loop.kernel.slab_columns import aligned
from frictionloop.quantities.counter_noise import BLOCK

_WHOLE = (
    "lanes",
    # the period: substeps or segments, those before the command changes, and whether its clock is imperfect
    *("segments", "before", "nodes", "irregular"),
    # signals that one column serves for all lanes
    *("setpoint_shared", "disturbance_shared", "noise_shared"),
    # the first period that is scored; the period with which the loop closes, 0 if it is closed
    *("score_from", "open_until"),
    # who acts: the caller commands (``Stepper``), or moves the finger
    *("external", "given"),
    # the carrier is made of pulses of whole ticks
    "pulsed",
    # lookup table and command history
    *("table_size", "ring_mask"),
    # samples of signals begin with this period; values per trace, 0 without traces
    *("chunk", "trace_size"),
    # the tile that runs whole blocks, 0 where a program of ticks does
    "whole",
)
SCRATCH = (
    *("setpoint", "disturbance", "driven", "normals", "history", "table", "seeds"),
    "draws",  # unit normals of tremor, position and load, one block after the other
    "roughness",  # table of n(x), ``[cell][lane]``
    "effect",  # program of an effect: its instructions and its tables
    "timing",  # unit normals of jitter and of lost ticks, one block after the other
    *("setpoint_samples", "disturbance_samples", "trace"),
    "path",  # of a finger that somebody moves: place, speed and load at the end of each period, [period][3]
)
PROGRAMS = ("blocks", "ticks", "obeys", "extras")
"""Tiles in the order in which they run: before each block of periods, in each period, when a command comes from
outside, and where a period is scored."""
_COUNTS = tuple(f"{name}_count" for name in PROGRAMS)
SHARED = np.dtype([("dt", float), *((name, np.int64) for name in (*_WHOLE, *SCRATCH, *PROGRAMS, *_COUNTS))])
"""Addresses are whole numbers: a record then is plain data for compiled code of any origin."""
RECORD = from_dtype(SHARED)
POINTER = types.CPointer(RECORD)


@intrinsic
def at(_context: Any, pointer: Any) -> Any:
    """Return the record at an address (compiled code only)."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], context.get_value_type(signature.return_type))

    return RECORD(pointer), generate


@intrinsic
def pointer_to(_context: Any, record: Any) -> Any:
    """Return where a record lies (compiled code only)."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], context.get_value_type(signature.return_type))

    return POINTER(record), generate


class Shared:
    """The record of one tile, and what keeps the arrays alive that it points to."""

    def __init__(self, **whole: float) -> None:
        self.record = np.zeros(1, SHARED)
        self.kept: dict[str, np.ndarray] = {}
        self.python: Any = None
        """A law in plain Python (loop/kernel/foreign_tile), which stops where it raises."""
        self.set(**whole)

    def set(self, **values: float) -> None:
        """Set some fields by name."""
        for name, value in values.items():
            self.record[name] = value

    def point(self, **arrays: np.ndarray) -> None:
        """Let some fields point to arrays."""
        for name, array in arrays.items():
            self.kept[name] = array
            self.record[name] = array.ctypes.data

    def program(self, name: str, addresses: list[int]) -> None:
        """Set the tiles of a program."""
        self.point(**{name: np.array(addresses, np.int64)})
        self.record[f"{name}_count"] = len(addresses)

    def __getattr__(self, name: str) -> Any:
        """Return a field by name."""
        return self.record[name][0].item()


def scratch(width: int, longest_delay: float, nodes: int, moving: bool) -> dict[str, np.ndarray]:
    """Return zeroed scratch for one tile, and its history of commands for a delay in periods.

    The history has length 1 without delay, else a power of two that holds two periods more.
    """
    ring = 1 << math.ceil(longest_delay + 1).bit_length() if longest_delay else 1
    return {
        "setpoint": aligned(BLOCK * width),
        "disturbance": aligned(nodes * BLOCK * width),
        "driven": aligned(BLOCK * width),
        "normals": aligned(BLOCK * width),
        "history": aligned(ring * width),
        "draws": aligned(4 * BLOCK * width if moving else 0),
        "timing": aligned(2 * BLOCK * width),
    }
