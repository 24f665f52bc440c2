"""What the controller believes of the plant."""

from __future__ import annotations

import math
import sys
from typing import Annotated, Self

from pydantic import Field, model_validator

from frictionloop.parameters.block import Block, NotNegative, Positive, Whole


class Model(Block):
    """What the controller believes: it alone feeds the lookup table, the clamp, notches and observers."""

    nominal_n: Positive = 0.8
    """Believed friction f0 without vibration: upper end of the clamp."""
    susceptibility_per_um2: Positive = 0.38
    """Believed susceptibility tau."""
    max_amplitude_um: Positive = 2.5
    """Believed largest amplitude: g(max_amplitude_um) is the lower end of the clamp."""
    plate_hz: Positive = 100.0
    """Believed cutoff of the plate's envelope."""
    resonance_hz: NotNegative = 0.0
    """Believed resonance of the force sensor's springs; 0 is none. Better too low than too high (docs/controllers)."""
    resonance_q: Positive = 20.0
    """Believed quality factor of that resonance."""
    sensor_hz: Positive = 1000.0
    """Believed cutoff of the sensor's electronics."""
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
