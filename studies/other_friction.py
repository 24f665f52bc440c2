"""Fingers whose friction falls otherwise than by equation (1): another exponent, and a floor.

Share left = c + (1 - c) exp(-tau a^p (1 - l w)), p = 2 and c = 0 in equation (1).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

import frictionloop as fl
from frictionloop.parameters import FingerFriction
from frictionloop.parameters.block import Number


class OtherFriction(FingerFriction):
    """As a finger's."""

    kind: Literal["other"] = "other"  # type: ignore[assignment]
    exponent: Annotated[Number, Field(gt=0, le=4)] = 2.0
    """p."""
    floor: Annotated[Number, Field(ge=0, lt=1)] = 0.0
    """c."""


class Falling(NamedTuple):
    """tau, p, c and the share of tau that moisture takes away."""

    tau: float
    exponent: float
    floor: float
    moist_loss: float


@fl.step
def left(amplitude_um: float, occluded: float, c: Falling) -> float:
    """Return the share of friction that is left."""
    effect = c.tau * amplitude_um**c.exponent * (1.0 - c.moist_loss * occluded)
    return c.floor + (1.0 - c.floor) * math.exp(-effect)


def _falling(friction: OtherFriction) -> Falling:
    return Falling(friction.susceptibility_per_um2, friction.exponent, friction.floor, friction.moist_loss)


fl.register(fl.Vibration("other", left, Falling, _falling), OtherFriction)
