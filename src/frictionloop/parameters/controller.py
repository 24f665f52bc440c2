"""Parameters of the controllers: the simplest, that which observes the friction force, and every kind there is."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from frictionloop.parameters.block import NotNegative, Number
from frictionloop.parameters.filtered import FilteredPiController, NotchPiController
from frictionloop.parameters.kinds import Kinds
from frictionloop.parameters.timing import Timing

LONGEST_DELAY = 8
"""Most whole periods of delay under an observer, which keeps the commands on their way."""


class Observing(Timing):
    """What laws on the observer of the friction force have in common (control/force_observer)."""

    bandwidth_hz: Annotated[Number, Field(gt=0, le=1e6)] = 2500.0
    """Ratio of disturbance to sensor noise as a frequency: corner of the observer, were the sensor without lag.

    The more, the less residual, up to half the control rate: noise is not what limits (control/disturbance_observer).
    """
    overdrive: bool = True
    """Whether the amplitude command overshoots so that the plate gets there in one period (paper, ref. [14])."""

    @model_validator(mode="after")
    def _commands_fit(self) -> Self:
        if not self.delay_s * self.rate_hz < LONGEST_DELAY + 1:
            raise ValueError(
                f"delay_s = {self.delay_s:g} s must be less than {LONGEST_DELAY + 1} control periods under an observer"
            )
        return self


class ObserverController(Observing):
    """u = clip(f_r - d, g(a_max), f0), d the observed force beyond the command's (control/disturbance_observer)."""

    kind: Literal["observer"] = "observer"


class PiController(Timing):
    """v = kp e + I, u = clip(v, g(a_max), f0), dI/dt = ki e with conditional integration (paper, Sec. 2.3)."""

    kind: Literal["pi"] = "pi"
    kp: NotNegative = 10.0
    """Proportional gain K_p (paper, Sec. 2.3)."""
    ki: NotNegative = 2.0
    """Integral gain K_i (paper, Sec. 2.3; per second is a reading)."""


class LookupController(Timing):
    """u = clip(f_r, g(a_max), f0): the lookup table alone, open loop (paper, Sec. 2.2 and ref. [15])."""

    kind: Literal["lookup"] = "lookup"
    overdrive: bool = False
    """Whether the amplitude command overshoots so that the plate gets there in one period (paper, ref. [14])."""


CONTROLLERS = Kinds(
    Timing,
    PiController,
    LookupController,
    FilteredPiController,
    NotchPiController,
    ObserverController,
    default="pi",
    tuned=True,
    beside={
        "super_twisting": "frictionloop.control.super_twisting:SuperTwistingController",
        "limit_observer": "frictionloop.control.limit_observer:LimitObserverController",
    },
    gone={
        "oracle": "is no law: this reference is studies/oracle.py of the source; take 'notch_pi' for a law",
        "tracker": "was removed, since quick steps made it ring; take 'notch_pi' (frictionloop design controller)",
        "open_loop": "is no kind; open loop is 'lookup': the table alone makes an amplitude of the set-point",
    },
)
Controller = Annotated[Timing, CONTROLLERS]
