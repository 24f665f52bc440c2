"""An effect as a program over tables: what the simulator's kernel runs, one lookup per period for a plain map.

Whatever depends on place alone becomes one table along the path. The rest is a list of instructions for a stack of
numbers. All of it is one row of numbers, plain enough for a microcontroller.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

MOST_TRIGGERS, STACK = 4, 8
WIDTH = 7
"""Numbers of an instruction: what it does, and what with."""
FAR_S = 1e6
"""Time since the last change of a trigger that has not changed yet."""


class Do(IntEnum):
    """What an instruction does with the stack."""

    TABLE = 0
    """Push a table at the place: first value, values, start in mm, values per mm, nearest, repeats."""
    WAVE = 1
    """Push a wave: first value, values, values per s, loops, trigger (-1: since the start), 1 since it turned on."""
    ADD = 2
    MULTIPLY = 3
    LARGER = 4
    MIX = 5
    """Pop outside, effect and share; push the mix."""
    DIRECTION = 6
    """Push 1 or -1."""
    SPEED = 7
    """Push a factor times the speed in mm/s, without its sign."""
    TRIGGER = 8
    """Push 1 if it is on, else 0: number, quantity, on, off, dead time."""
    SCALED = 9
    """Push the top of the stack times a factor."""


class Program(NamedTuple):
    """An effect along a path, compiled."""

    code: tuple[tuple[float, ...], ...]
    """Instructions of `WIDTH` numbers."""
    tables: bytes
    """Values of all tables, float64."""
    triggers: int
    error_n: float
    """Largest difference between a table and what it stands for, midway between its values."""
    low_n: float
    """Least and largest force of tables of place, as far as they say it."""
    high_n: float

    @property
    def values(self) -> np.ndarray:
        """The values of all tables."""
        return np.frombuffer(self.tables)

    @property
    def numbers(self) -> np.ndarray:
        """The whole program as one row: how many instructions, these, then the tables."""
        return np.concatenate([[len(self.code)], np.array(self.code, float).ravel(), self.values])

    @property
    def is_plain(self) -> bool:
        """Whether it is one table."""
        return len(self.code) == 1 and self.code[0][0] == Do.TABLE


class TriggerStates(NamedTuple):
    """Whether each trigger is on, and the time since it last changed, s."""

    on_0: float
    on_1: float
    on_2: float
    on_3: float
    since_0: float
    since_1: float
    since_2: float
    since_3: float


class EffectState(NamedTuple):
    """What an effect keeps from period to period."""

    direction: float
    held_n: float
    triggers: TriggerStates


START = EffectState(1.0, 0.0, TriggerStates(*[0.0] * MOST_TRIGGERS, *[FAR_S] * MOST_TRIGGERS))
"""Before the first period: no trigger has changed for long."""
