"""A control law as somebody writes it outside the package: half of the wish. `register` is left to who uses it."""

from __future__ import annotations

from typing import Literal, NamedTuple

import frictionloop as fl


class HalfController(fl.Timing):
    kind: Literal["half"] = "half"
    share: float = 0.5
    """Share of the wish that is commanded."""


class State(NamedTuple):
    nothing: float


class Gains(NamedTuple):
    share: float
    low: float
    high: float


@fl.step
def half(state, measured, setpoint_n, gains, dt):
    v = gains.share * setpoint_n
    u = min(max(v, gains.low), gains.high)
    return state, fl.ForceCommand(u, 1.0 if u != v else 0.0)
