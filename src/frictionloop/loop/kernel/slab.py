"""The state of a tile of lanes as one array: a row per quantity, a column per lane (structure of arrays).

Rows have fixed numbers, so the compiler knows the distance between any two of them and vectorises the loops over lanes
without checking for overlap.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from frictionloop.control.law import Law
from frictionloop.loop.kernel.ends import TERMS
from frictionloop.loop.kernel.quadrature import MAX_SEGMENTS, NODES
from frictionloop.physics.plate import PlateCoefficients
from frictionloop.physics.vibration import Vibration
from frictionloop.quantities import FrictionloopError, trees

LANES = 32
"""Lanes of a full tile: best of 16 to 256 in C, and 4 registers of 8 doubles."""
NODES_MAX = 2 * MAX_SEGMENTS * (NODES - 1) + 1
SEGMENT_ROWS = 1 + 2 * TERMS
VIBRATION_ROWS = 16
"""Room for the coefficients of a friction law."""
LAW_ROWS = 256
"""Room for a law: twice its states, and its gains."""

_ROWS: tuple[tuple[str, int], ...] = (
    # what changes every period
    ("measurement", 5),  # force, position, speed, load, valid
    ("setpoint", 1),
    ("disturbance", 1),
    ("normal", 1),
    ("driven", 1),  # what the disturbance adds to the reading over the period
    ("u", 1),
    ("saturated", 1),
    ("command", 1),
    ("amplitude", 1),
    ("friction", 1),  # g(a) at t_k
    ("applied", 2),  # amplitude command in force before and after the switch
    # coefficients
    ("believed_clamp", 2),  # lowest and highest force command; while the loop is open or closes the clamp is another
    ("overdrive", 1),  # believed amplitude
    ("overdrive_gains", 3),
    ("model", 5),  # log2 f0, ln 2 / tau, clamp low, table cells per newton, last cell
    ("at_limits", 2),  # commands at the low and the high end of the clamp
    ("nominal", 1),
    ("halving_amplitude", 2),  # in um, and its inverse
    ("max_amplitude", 1),
    ("floor", 1),
    ("pulse_ticks", 1),
    ("weight", NODES_MAX),  # of the disturbance at the nodes
    ("segment", 2 * MAX_SEGMENTS * SEGMENT_ROWS),  # each: the plate's decay, and the terms of start and end
    ("sensor_decay", 1),
    ("noise_gain", 1),
    ("delay_periods", 1),
    ("node_time", NODES_MAX),
    ("setpoint_signal", 4),  # offset, amplitude, two of the phase
    ("disturbance_signal", 4),
    ("swing", 3),  # of a sine's share of the reading: steady, in phase, a quarter turn later
    # the bench: a finger that moves, skin that yields, a sensor that resonates
    ("motion", 7),  # at t_k: position (m), speed (m/s), load (N), factor on f0, occluded, direction, place along stroke
    ("motion_next", 7),  # the same at t_k+1
    ("rough", 1),
    ("stroke_plan", 9),
    ("load_plan", 11),
    ("tremor", 4),  # displacement and load, each with its rate
    ("tremor_coefficients", 12),
    ("limit_coefficients", 6),
    ("occlusion_coefficients", 2),
    ("static", 2),  # static ratio less 1, and the inverse of its speed
    ("vibration", VIBRATION_ROWS),  # coefficients of the friction law
    ("roughness_per_m", 1),
    ("touch", 4),
    ("touch_coefficients", 10),
    ("draws", 4),  # unit normals of both tremors, of position and load
    ("limit_n", 1),  # f0
    ("scored", 1),  # 1 where a period counts
    ("unscored", 2),  # way from the middle, in m, beyond which nothing counts; least load that counts, in N
    ("switch", 1),  # when in the period the command changes, 0 to 1
    ("timing", 3),  # the same without jitter, jitter in periods, normal below which a tick is lost
    ("timing_draws", 2),
    ("kept", 4),  # commands before a tick that may be lost
    ("contact", 4),
    ("contact_force", 1),
    ("vibrated_limit", 1),  # friction limit at t_k under the amplitude of then
    ("contact_coefficients", 10),
    ("compliance", 1),  # of the skin, m/N
    ("plate_coefficients", len(PlateCoefficients._fields)),
    ("suspension", 3),
    ("suspension_coefficients", 10),
    ("noise", 1),
    ("noise_coefficients", 2),
    ("converter", 3),
    # the oracle
    ("wanted", 1),  # set-point that it is after
    ("ahead", 5),  # amplitude and contact when the command takes effect
    ("tried", 5),  # the same in a trial
    ("trial", 7),
    ("trial_stride", len(PlateCoefficients._fields) + 10),  # of plate and contact, for the longer steps of a trial
    ("trial_decay", 1),  # of the amplitude, over a period
    ("law", LAW_ROWS),  # a law's state, its gains, and its state before a tick that may be lost
)
ROW: dict[str, int] = {}
COUNT: dict[str, int] = dict(_ROWS)
for _name, _count in _ROWS:
    ROW[_name] = sum(COUNT[n] for n in ROW)
ROWS = sum(COUNT.values())


def rows(name: str, count: int | None = None) -> tuple[int, ...]:
    """Return the row numbers of a quantity, the first ``count`` of them."""
    return tuple(range(ROW[name], ROW[name] + (COUNT[name] if count is None else count)))


def shaped_rows(name: str, shape: Any) -> Any:
    """Return the row numbers of a quantity in the shape of a named tuple class."""
    return trees.shaped(shape, rows(name))


def law_rows(law: Law) -> tuple[Any, Any]:
    """Return the row numbers of a law's state and of its gains, in the shapes that its step takes.

    Raises
    ------
    FrictionloopError
        For a law with more numbers than there is room for.
    """
    states, gains, first = trees.size(law.state), trees.size(law.gains), ROW["law"]
    if 2 * states + gains > LAW_ROWS:
        raise FrictionloopError(
            f'law "{law.kind}": {states} states and {gains} gains; twice the states and the gains must be at most '
            f"{LAW_ROWS} numbers"
        )
    numbers = range(first, first + LAW_ROWS)
    return trees.shaped(law.state, numbers), trees.shaped(law.gains, numbers[states:])


def vibration_rows(vibration: Vibration) -> Any:
    """Return the row numbers of a friction law's coefficients, in the shape that its step takes."""
    count, first = trees.size(vibration.coefficients), ROW["vibration"]
    if count > VIBRATION_ROWS:
        raise FrictionloopError(f'friction law "{vibration.kind}": {count} coefficients; at most {VIBRATION_ROWS}')
    return trees.shaped(vibration.coefficients, range(first, first + count))


def kept_rows(law: Law) -> tuple[int, ...]:
    """Return the rows that keep a law's state while a tick may be lost."""
    first = ROW["law"] + trees.size(law.state) + trees.size(law.gains)
    return tuple(range(first, first + trees.size(law.state)))


def aligned(size: int) -> np.ndarray:
    """Return zeros that begin on a cache line: a vector of 8 doubles then never straddles two."""
    line = 64
    room = np.zeros(size + line // 8)
    start = -room.ctypes.data % line // 8
    return room[start : start + size]


class Slab:
    """The rows of one tile, addressed by name; ``width`` is 1 for a single lane, else ``LANES``."""

    def __init__(self, width: int, rows: int = ROWS) -> None:
        self.width = width
        self.data = aligned(rows * width)

    def view(self, name: str) -> np.ndarray:
        """Return the rows of a quantity as a view of shape (count, width)."""
        start = ROW[name] * self.width
        return self.data[start : start + COUNT[name] * self.width].reshape(COUNT[name], self.width)

    def rows(self, numbers: Sequence[int]) -> np.ndarray:
        """Return adjoining rows by their numbers as a view of shape (count, width)."""
        start = numbers[0] * self.width
        return self.data[start : start + len(numbers) * self.width].reshape(len(numbers), self.width)
