"""Coefficients that the firmware adds up before it rounds: a row of a matrix, with one shift (firmware/core/fl_row.h)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from frictionloop.control.quantised import SHIFTS, WORD, Gain, to_places
from frictionloop.quantities import FrictionloopError


def to_row(values: Sequence[float], inputs: Sequence[int], output: int, name: str) -> list[Gain]:
    """Return the coefficients of a row, all with the largest shift at which its sum cannot overflow.

    Parameters
    ----------
    values
        Coefficients, each of an input.
    inputs
        Binary places of the inputs.
    output
        Binary places of the sum. A coefficient holds 2^(output - input) too.
    name
        What the row is, for errors.

    Raises
    ------
    FrictionloopError
        When the coefficients are too large for any shift.
    """
    scaled = [math.ldexp(value, output - places) for value, places in zip(values, inputs, strict=True)]
    total = sum(map(abs, scaled))
    room = WORD - len(scaled)  # rounding adds at most half to each
    if not total * 2.0 ** SHIFTS[0] < room:
        raise FrictionloopError(f"{name}: coefficients that add up to {total:g} do not fit the firmware")
    shift = min(math.floor(math.log2(room / total)) if total else SHIFTS[1], SHIFTS[1])
    return [Gain(round(math.ldexp(value, shift)), shift) for value in scaled]


def to_fixed(value: float, places: int, name: str) -> Gain:
    """Return a number of which the C step reads the mantissa alone, in these places."""
    return Gain(to_places(value, places, name), places)
