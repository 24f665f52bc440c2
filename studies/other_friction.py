"""Fingers whose friction falls otherwise than by equation (1): to c + (1 - c) exp(-tau a^p (1 - l w))."""

import math
from typing import Literal, NamedTuple

import frictionloop as fl
from frictionloop.parameters import FingerFriction
from frictionloop.parameters.block import Number


class OtherFriction(FingerFriction):
    """As a finger's, with the exponent p and the floor c, which are 2 and 0 in equation (1)."""

    kind: Literal["other"] = "other"  # type: ignore[assignment]
    exponent: Number = 2.0
    floor: Number = 0.0


class _Falling(NamedTuple):
    tau: float
    exponent: float
    floor: float
    loss: float


@fl.step
def _left(amplitude_um: float, occluded: float, c: _Falling) -> float:
    return c.floor + (1.0 - c.floor) * math.exp(-c.tau * amplitude_um**c.exponent * (1.0 - c.loss * occluded))


def _falling(f: OtherFriction) -> _Falling:
    return _Falling(f.susceptibility_per_um2, f.exponent, f.floor, f.moist_loss)


OTHER = fl.Vibration("other", _left, _Falling, _falling)
