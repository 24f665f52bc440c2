"""By how much the firmware's words change the force of an effect; what they do not hold is refused."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.quantities import must_be
from frictionloop.rendering.program import Do, Program

FARTHEST_M = 0.5
"""Distance from place to place that the firmware can tell."""
LARGEST_N, FASTEST_M_S = 8.0, 1.0
"""Force that a word holds; speed with which forces of speed must fit it (assumed)."""
FULL = 32767
BIT_N = 2.0**-27
"""Two steps of a force in the firmware."""


class _Force(NamedTuple):
    """What a step leaves on the stack."""

    largest_n: float
    error_n: float
    """By how much the words may be off, N."""


def rounded_by_n(program: Program) -> float:
    """Return by how much the rounding to words may change the force, N, a place being 0.5 nm off at most.

    A value is rounded to 2^-15 of the largest of its table, and a share between two values to 2^-16. A product carries
    the error of each factor times the other.

    Raises
    ------
    FrictionloopError
        For what the firmware's words do not hold: a force of 8 N, a place half a metre from the others.
    """
    stack: list[_Force] = []
    for do, *numbers in program.code:
        if do <= Do.WAVE:
            stack.append(_of_table(program, *map(int, numbers[:2]), repeats=bool(numbers[5 if do == Do.TABLE else 3])))
        elif do in (Do.DIRECTION, Do.TRIGGER):
            stack.append(_Force(1.0, 0.0))
        elif do == Do.SPEED:
            stack.append(_Force(abs(1e3 * numbers[0]) * FASTEST_M_S, BIT_N))
        elif do == Do.SCALED:
            stack.append(_Force(*(abs(numbers[0]) * each for each in stack.pop())))
        elif do == Do.MIX:
            share, one, other = (stack.pop(k) for k in (-3, -2, -1))
            apart = one.largest_n + other.largest_n  # their difference is a word too
            stack.append(_Force(apart, max(one.error_n, other.error_n) + share.error_n * apart + BIT_N))
        else:
            b, a = stack.pop(), stack.pop()
            stack.append(_mixed(do, a, b))
        if not stack[-1].largest_n < LARGEST_N:
            raise must_be("effect: force", stack[-1].largest_n, f"below {LARGEST_N:g}", "N")
        places = (numbers[2],) if do == Do.TABLE else numbers[2:4] if do == Do.TRIGGER and numbers[1] == 2 else ()
        for place_mm in places:
            if not 1e-3 * abs(place_mm) < 0.5 * FARTHEST_M:
                raise must_be("effect: place", float(place_mm), "-250 to 250", "mm")
    return stack[0].error_n


def _of_table(program: Program, first: int, count: int, *, repeats: bool) -> _Force:
    values = program.values[first : first + count + repeats]
    largest = float(np.max(np.abs(values)))
    rise = float(np.max(np.abs(np.diff(values))))
    return _Force(largest, 0.5 * largest / FULL + rise * 2.0**-16 + BIT_N)


def _mixed(do: float, a: _Force, b: _Force) -> _Force:
    if do == Do.ADD:
        return _Force(a.largest_n + b.largest_n, a.error_n + b.error_n)
    if do == Do.LARGER:
        return _Force(max(a.largest_n, b.largest_n), max(a.error_n, b.error_n))
    error_n = a.largest_n * b.error_n + b.largest_n * a.error_n + a.error_n * b.error_n + BIT_N
    return _Force(a.largest_n * b.largest_n, error_n)
