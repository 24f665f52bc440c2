"""What a run may be asked for."""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import Any

from frictionloop.device.recorder import TICK_HZ
from frictionloop.quantities import must_be

ABOVE = "a number above 0, in s"


def number(name: str, value: Any, accepted: str = "a finite number") -> float:
    """Return a finite number; anything else is refused by name."""
    if not isinstance(value, Real) or not math.isfinite(value):
        raise must_be(name, value, accepted)
    return float(value)


def check_decimation(decimation: Any) -> None:
    """Refuse what is no number of ticks per sample."""
    if not (isinstance(decimation, Integral) and 1 <= int(decimation) <= 65535):
        raise must_be("decimation", decimation, "whole, 1 to 65535")


def rows_of(duration_s: Any, decimation: Any) -> int:
    """Return the samples of a run: its duration over theirs, rounded up.

    Raises
    ------
    FrictionloopError
        For a duration that is not above 0, or a decimation that is not from 1 to 65535.
    """
    check_decimation(decimation)
    if number("duration_s", duration_s, ABOVE) <= 0:
        raise must_be("duration_s", duration_s, ABOVE)
    rows = duration_s * TICK_HZ / decimation
    return max(math.ceil(rows * (1 - 1e-9)), 1)  # 0.3 s are 1500 ticks, whatever the last bit of 0.3 says
