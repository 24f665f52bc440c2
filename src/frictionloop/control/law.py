"""What every control law has in common: its step and its rows of numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


class Clamp(NamedTuple):
    """Lowest and highest force in N that the controller's model can command: the last two gains of every law."""

    low: float
    high: float


class ForceCommand(NamedTuple):
    """Force u after the clamp in N, and whether the clamp acted (1 or 0)."""

    u: float
    saturated: float


class Law(NamedTuple):
    """A control law: ``step(state, measurement, setpoint_n, gains, dt) -> state, ForceCommand``."""

    kind: str
    """Kind of the parameters it runs with."""
    step: Any
    states: int
    gains_of: Callable[[Any], tuple[float, ...]]
    """Controller parameters -> gains of the step without the clamp."""
    gains: int
    """How many these are."""
    start_of: Callable[[Any], tuple[float, ...]] | None = None
    """Controller parameters -> state at t = 0; all zero where it is missing."""
    frozen: tuple[int, ...] = ()
    """Indices of slow states (estimates of the finger), which the linear analysis holds where they are."""
    begin: Any = None
    """``begin(force_n, setpoint_n, gains)`` -> integral, state 0, that commands this force without an error; None of a
    law that has no integral."""
    follow: Any = None
    """``follow(state, command_um, gains) -> state`` of a law that was not obeyed; None of one whose clamp tells it."""
