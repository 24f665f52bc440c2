"""An effect as a program over tables, and one control period of it: what `Player` runs, and the kernel compiled.

Whatever depends on place alone becomes one table along the path. The rest is a list of instructions for a stack of
numbers. All of it is one row of numbers (`Program.numbers`), plain enough for a microcontroller; what is kept from
period to period, and the stack, are numbers a stride apart, so that lanes may lie side by side.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from frictionloop.rendering.effect import TURNS_MM_S

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


ON, SINCE = 2, 2 + MOST_TRIGGERS
"""Where triggers stand in an `EffectState`, behind the direction and the force that is held."""
KEPT = 2 + len(START.triggers)
"""Numbers of an `EffectState`."""
TABLE, WAVE, ADD, MULTIPLY, LARGER, MIX, DIRECTION, SPEED, TRIGGER, SCALED = (int(do) for do in Do)


def build_play(compiled: Any, stride: int, plain: bool) -> Any:
    """Return ``play(s, at, stack, p, along_mm, speed_mm_s, load_n, touches_n, band_n, time_s, begins, dt)``.

    It is one period: the force that is asked for, and by how much the band has limited it.

    Parameters
    ----------
    compiled
        Decorator of its functions; one that does nothing leaves them plain Python.
    stride : int
        From a number that is kept to the next.
    plain : bool
        Whether the program is one table, which needs no stack.
    """
    table = _build_table(compiled)
    run = _build_run(compiled, stride, table)

    def play(s, at, stack, p, along_mm, speed_mm_s, load_n, touches_n, band_n, time_s, begins, dt):  # type: ignore[no-untyped-def]
        beyond = 0.0
        if abs(speed_mm_s) > TURNS_MM_S or begins:
            s[at] = -1.0 if speed_mm_s < -TURNS_MM_S else 1.0
        if load_n >= touches_n or begins:
            if plain:
                raw = table(p, 1, 1 + WIDTH, along_mm)
            else:
                raw = run(s, at, stack, p, along_mm, speed_mm_s, load_n, time_s, begins)
            held = min(max(raw, band_n[0]), band_n[1])
            s[at + stride] = held
            beyond = raw - held
        if not plain:
            for k in range(MOST_TRIGGERS):
                s[at + (SINCE + k) * stride] += dt
        return s[at + stride], beyond

    return compiled(play)


def _build_run(compiled: Any, stride: int, table: Any) -> Any:
    """Return ``run(s, at, stack, p, along_mm, speed_mm_s, load_n, time_s, begins)``: all instructions."""
    wave, trigger = _build_wave(compiled, stride), _build_trigger(compiled, stride)

    def run(s, at, stack, p, along_mm, speed_mm_s, load_n, time_s, begins):  # type: ignore[no-untyped-def]
        count = int(p[0])
        tables, top = 1 + count * WIDTH, stack
        for k in range(count):
            j = 1 + k * WIDTH
            do, first = int(p[j]), tables + int(p[j + 1])
            value = 0.0
            if do == TABLE:
                value = table(p, j, first, along_mm)
            elif do == WAVE:
                value = wave(s, at, p, j, first, time_s)
            elif do == TRIGGER:
                quantity = load_n if p[j + 2] == 0.0 else abs(speed_mm_s) if p[j + 2] == 1.0 else along_mm
                value = trigger(s, at, p, j, quantity, begins)
            elif do == DIRECTION:
                value = s[at]
            elif do == SPEED:
                value = p[j + 1] * abs(speed_mm_s)
            elif do == SCALED:
                top -= stride
                value = p[j + 1] * s[top]
            elif do == MIX:
                top -= 3 * stride
                share, one, other = s[top], s[top + stride], s[top + 2 * stride]
                value = other + min(max(share, 0.0), 1.0) * (one - other)
            else:
                top -= 2 * stride
                a, b = s[top], s[top + stride]
                value = a + b if do == ADD else a * b if do == MULTIPLY else max(a, b)
            s[top] = value
            top += stride
        return s[stack]

    return compiled(run)


def _build_table(compiled: Any) -> Any:
    """Return ``table(p, j, first, along_mm)``: the table of the instruction at ``j``."""

    def table(p, j, first, along_mm):  # type: ignore[no-untyped-def]
        count, repeats = p[j + 2], p[j + 6] > 0.0
        u = (along_mm - p[j + 3]) * p[j + 4]
        u = u - count * math.floor(u / count) if repeats else min(max(u, 0.0), count - 1.0)
        u = math.floor(u + 0.5) if p[j + 5] > 0.0 else u
        cell = min(int(u), int(count) - (1 if repeats else 2))
        here, after = p[first + cell], p[first + cell + 1]
        return here + (u - cell) * (after - here)

    return compiled(table)


def _build_wave(compiled: Any, stride: int) -> Any:
    """Return ``wave(s, at, p, j, first, time_s)``: a wave since the start, or since its trigger."""

    def wave(s, at, p, j, first, time_s):  # type: ignore[no-untyped-def]
        count, loops, trigger = p[j + 2], p[j + 4] > 0.0, int(p[j + 5])
        if trigger >= 0:
            time_s = s[at + (SINCE + trigger) * stride]
            if s[at + (ON + trigger) * stride] != p[j + 6] or time_s >= FAR_S:
                return 0.0
        u = time_s * p[j + 3]
        if loops:
            u -= count * math.floor(u / count)
        elif u > count - 1.0:
            return 0.0
        cell = min(int(u), int(count) - (1 if loops else 2))
        here, after = p[first + cell], p[first + cell + 1]
        return here + (u - cell) * (after - here)

    return compiled(wave)


def _build_trigger(compiled: Any, stride: int) -> Any:
    """Return ``trigger(s, at, p, j, quantity, begins)``: 1 if it is on, else 0, after it has changed or not."""

    def trigger(s, at, p, j, quantity, begins):  # type: ignore[no-untyped-def]
        number = int(p[j + 1])
        on, off = p[j + 3], p[j + 4]
        is_on, since = at + (ON + number) * stride, at + (SINCE + number) * stride
        now_on = quantity >= on if on > off else quantity <= on
        now_off = quantity <= off if on > off else quantity >= off
        if begins:
            s[is_on] = 1.0 if now_on else 0.0
        elif s[since] >= p[j + 5] and (now_off if s[is_on] > 0.0 else now_on):
            s[is_on], s[since] = 1.0 - s[is_on], 0.0
        return s[is_on]

    return compiled(trigger)
