"""Parameters of the laws that observe the friction force."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from frictionloop.parameters.block import Number
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
