"""Numbers as the firmware holds them, and what the fixed-point form of a law is made of (firmware/core/fl_fixed.h)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from frictionloop.quantities import must_be

MANTISSA_BITS = 30
SHIFTS = (-1, 62)
"""Least and largest shift of a gain."""
ROW = 28
"""Binary places of the coefficients of a row."""
WORD = 2**31
"""Numbers of 32 bits go from -2^31 to 2^31 - 1."""


class Gain(NamedTuple):
    """A coefficient: mantissa 2^-shift."""

    mantissa: int
    shift: int


class Quantised(NamedTuple):
    """The fixed-point form of a law, beside its `Law`."""

    gains: Callable[[Any], Sequence[Gain]]
    """Controller parameters -> gains in the order that its C step takes them."""
    places: Callable[[Any], tuple[int, ...]]
    """Controller parameters -> binary places of each state."""


def to_q28(value: float, name: str) -> int:
    """Return the nearest multiple of 2^-28, as a whole number of them.

    Raises
    ------
    FrictionloopError
        When it is not within -8 to 8, which is what 32 bits hold.
    """
    return to_places(value, 28, name)


def to_places(value: float, places: int, name: str) -> int:
    """Return the nearest multiple of 2^-places, as a whole number of them; an error where 32 bits do not hold it."""
    scaled = value * 2.0**places
    if not -WORD - 0.5 <= scaled < WORD - 0.5:
        largest = math.ldexp(1.0, 31 - places)
        raise must_be(name, float(value), f"-{largest:g} to {largest:g} on a board")
    return math.floor(scaled + 0.5)


def to_gain(value: float, name: str = "gain") -> Gain:
    """Return mantissa and shift of a coefficient: 30 bits, value = mantissa 2^-shift to a relative 2^-30.

    Below 2^-33 in magnitude the mantissa has fewer bits, and the error stays below 2^-63.

    Raises
    ------
    FrictionloopError
        When it is not finite or its magnitude is 2^31 or more.
    """
    if not abs(value) < WORD:
        raise must_be(name, float(value), "below 2^31 in magnitude")
    _, exponent = math.frexp(value)
    shift = min(MANTISSA_BITS - exponent, SHIFTS[1])
    mantissa = round(math.ldexp(value, shift))
    if abs(mantissa) == 1 << MANTISSA_BITS:  # rounded up to the next power of 2
        mantissa, shift = mantissa // 2, shift - 1
    if shift < SHIFTS[0]:
        raise must_be(name, float(value), "below 2^31 in magnitude")
    return Gain(mantissa, shift) if value else Gain(0, 0)


def pi_gains(controller: Any) -> tuple[Gain, ...]:
    """Return kp and ki dt of `pi_step`."""
    return to_gain(controller.kp, "controller.kp"), integral_gain(controller)


def integral_gain(controller: Any) -> Gain:
    """Return ki dt, by which an error goes into the integral in a period.

    The integral is at most by ki dt e beyond the clamp. Forces that differ by 8 N and an integral within 8 N leave
    (8 - f0)/8 for ki dt; more would mean an integral that overflows.
    """
    step, room = controller.ki / controller.rate_hz, 1.0 - controller.model.nominal_n / 8.0
    if not step <= room:
        raise must_be("controller.ki", float(controller.ki), f"at most {room * controller.rate_hz:g} on a board", "1/s")
    return to_gain(step, "controller.ki / rate_hz")


def to_fixed(value: float, places: int, name: str) -> Gain:
    """Return a coefficient whose C step reads the mantissa alone, in these places."""
    return Gain(to_places(value, places, name), places)
