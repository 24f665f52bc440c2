"""What every control law declares, once: kernels, start values, traces and the linear analysis follow from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from frictionloop.parameters import Model
from frictionloop.quantities import flat_tuples, must_be
from frictionloop.quantities.class_help import Brief, brief
from frictionloop.quantities.scalar_math import fma, step


@brief
class Clamp(NamedTuple):
    """Lowest and highest force in N that the controller's model can command."""

    low: float
    high: float


@brief
class ForceCommand(NamedTuple):
    """Force u after the clamp in N, and whether the clamp acted (1 or 0)."""

    u: float
    saturated: float


def clamp_of(model: Model) -> Clamp:
    """Return g(a_max) and f0, the last two gains of every law.

    Parameters
    ----------
    model
        A controller's ``model``.

    Raises
    ------
    FrictionloopError
        For what is no model.
    """
    if not isinstance(model, Model):
        raise must_be("model", model, "controller.model")
    return Clamp(model.floor_n, model.nominal_n)


@dataclass(frozen=True)
class Law(metaclass=Brief):
    """A control law: ``step(state, measurement, setpoint_n, gains, dt) -> state, ForceCommand``.

    State and gains are named tuples of numbers, which may hold named tuples. The last two gains of every law are
    ``low`` and ``high``, the clamp: the loop moves them while it is opened and closed.
    """

    kind: str
    """Kind of the parameters it runs with."""
    step: Any
    state: type
    gains: type
    gains_of: Callable[[Any], Any] | None = None
    """Controller parameters -> gains; without it they are the parameters of the same names."""
    start_of: Callable[[Any], Any] | None = None
    """Controller parameters -> state at t = 0; all zero without it."""
    begin: Any = None
    """``begin(state, force_n, setpoint_n, gains) -> state`` that commands this force without an error, as the loop
    closes; None of a law that has no integral."""

    def gains_for(self, controller: Any) -> Any:
        """Return the gains of a controller."""
        if self.gains_of is not None:
            return self.gains_of(controller)
        own = {name: getattr(controller, name) for name in self.gains._fields[:-2]}  # type: ignore[attr-defined]
        return self.gains(**own, **clamp_of(controller.model)._asdict())

    def start_for(self, controller: Any) -> Any:
        """Return the state of a controller at t = 0."""
        if self.start_of is not None:
            return self.start_of(controller)
        return flat_tuples.shaped(self.state, [0.0] * flat_tuples.size(self.state))


CLOSING = 512
"""Control periods over which the clamp opens after closing, 0.1 s (assumed)."""


@step
def switched_clamp(setpoint_n: float, low_n: float, high_n: float, since: int) -> tuple[float, float]:
    """Return the clamp of a law so many periods after the loop closed, below 0 while it is open.

    Open, the lookup alone commands, u = clip(f_r). The law runs along with both ends of its clamp there, so that its
    observers know what goes on. When the loop closes an integral begins with what open loop commands, and the lower end
    of the clamp comes down from there to where it belongs, in a line: the amplitude begins with at most what the
    set-point asks for, and the law's anti-windup knows why.
    """
    open_n = min(max(setpoint_n, low_n), high_n)
    down = fma((CLOSING - since) / CLOSING, open_n - low_n, low_n)
    return (open_n if since <= 0 else down), (open_n if since < 0 else high_n)
