"""Coefficients of the firmware with a constant shift: rows of a matrix and single ones (firmware/core/fl_row.h)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from frictionloop.firmware.quantised import Gain, to_places

ROW = 28
"""Binary places of the coefficients of a row."""


def to_row(values: Sequence[float], inputs: Sequence[int], output: int, name: str) -> list[Gain]:
    """Return the coefficients of a row.

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
        When one is 8 or more in magnitude.
    """
    places = [output - given for given in inputs]
    return [to_fixed(math.ldexp(value, more), ROW, name) for value, more in zip(values, places, strict=True)]


def to_fixed(value: float, places: int, name: str) -> Gain:
    """Return a coefficient whose C step reads the mantissa alone, in these places."""
    return Gain(to_places(value, places, name), places)
