"""Parameters of the controller: what it believes of the plant, its gains and its timing."""

from __future__ import annotations

import math
import sys
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from frictionloop.parameters.block import Block, NotNegative, Number, Positive, Whole


class Model(Block):
    """What the controller believes: it alone feeds the lookup table and the clamp."""

    nominal_n: Positive = 0.8
    """Believed friction f0 without vibration: upper end of the clamp."""
    susceptibility_per_um2: Positive = 0.38
    """Believed susceptibility tau."""
    max_amplitude_um: Positive = 2.5
    """Believed largest amplitude: g(max_amplitude_um) is the lower end of the clamp."""
    table_size: Annotated[Whole, Field(ge=0, le=65536)] = 0
    """Entries of the lookup table, interpolated linearly in amplitude squared; 0 is the exact inverse."""

    @model_validator(mode="after")
    def _table(self) -> Self:
        if self.table_size == 1:
            raise ValueError("table_size must be 0 (exact inverse) or at least 2")
        return self

    @model_validator(mode="after")
    def _clamp(self) -> Self:
        if not sys.float_info.min <= self.floor_n < self.nominal_n:
            raise ValueError(
                f"susceptibility_per_um2 and max_amplitude_um give a clamp from {self.floor_n:g} to "
                f"{self.nominal_n:g} N, which must be an interval above 0"
            )
        return self

    @property
    def floor_n(self) -> float:
        """Lowest force the controller believes reachable, g(max_amplitude_um)."""
        return self.nominal_n * math.exp(-self.susceptibility_per_um2 * (self.max_amplitude_um * self.max_amplitude_um))


class PiController(Block):
    """v = kp e + I, u = clip(v, g(a_max), f0), dI/dt = ki e with conditional integration (paper, Sec. 2.3)."""

    kind: Literal["pi"] = "pi"
    kp: NotNegative = 10.0
    """Proportional gain K_p (paper, Sec. 2.3)."""
    ki: NotNegative = 2.0
    """Integral gain K_i (paper, Sec. 2.3; per second is a reading)."""
    rate_hz: Annotated[Number, Field(gt=0, le=1e9)] = 5000.0
    """Rate of the control periods (paper, Sec. 4.1: "5 kHz timer")."""
    delay_s: Annotated[Number, Field(ge=0, le=1)] = 0.0
    """Time from taking the sample to applying the amplitude command."""
    jitter_s: Annotated[Number, Field(ge=0, le=1)] = 0.0
    """Chance lateness of the command, |normal| of this standard deviation, at most to the end of its period."""
    lost_ticks: Annotated[Number, Field(ge=0, lt=1)] = 0.0
    """Share of ticks that do not happen: the controller keeps its state and its command."""
    model: Model = Model()
    """What the controller believes of the plant."""


Controller = PiController
