"""What all controllers have: when they run, and what they believe of the plant."""

from __future__ import annotations

import math
import sys
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from frictionloop.parameters.block import Block, NotNegative, Number, Positive, Whole


class Model(Block):
    """What the controller believes: it alone feeds the lookup table, the clamp, notches and observers."""

    nominal_n: Positive = 0.8
    """Believed friction f0 without vibration: upper end of the clamp."""
    susceptibility_per_um2: Positive = 0.38
    """Believed susceptibility tau."""
    gain_spread: Annotated[Number, Field(ge=1, le=10)] = 2.7
    """Factor by which a finger's loop gain may be above the believed one; designs hold Ms 2.9 up to it.

    Of the capable people of the assumed population five in six bring less than 2.7. Of a finger measured by two plain
    strokes it is 1.1 (assumed: load and speed change by 10 % from stroke to stroke).
    """
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
    table_um2: tuple[NotNegative, ...] = ()
    """Measured table: a^2 at forces evenly from g(max_amplitude_um) to f0, falling to 0; none: the law's own."""

    @model_validator(mode="after")
    def _table(self) -> Self:
        if self.table_size == 1:
            raise ValueError("table_size must be 0 or at least 2")
        if self.table_um2:
            table = self.table_um2
            if len(table) < 2 or table[-1] != 0 or any(b >= a for a, b in pairwise(table)):
                raise ValueError("table_um2 must fall to 0")
            if self.table_size == 0:
                raise ValueError(f"table_um2 needs table_size = {len(table)}")
        return self

    @model_validator(mode="after")
    def _clamp(self) -> Self:
        if not sys.float_info.min <= self.floor_n < self.nominal_n:
            raise ValueError(
                f"susceptibility_per_um2, max_amplitude_um: clamp from {self.floor_n:g} to {self.nominal_n:g} N "
                "must rise above 0"
            )
        return self

    @property
    def floor_n(self) -> float:
        """Lowest force the controller believes reachable, g(max_amplitude_um)."""
        return self.nominal_n * math.exp(-self.susceptibility_per_um2 * (self.max_amplitude_um * self.max_amplitude_um))


class Timing(Block):
    """What all controllers have: when they run, and what they believe of the plant."""

    if TYPE_CHECKING:

        @property
        def kind(self) -> str:
            """Name of the law."""

    rate_hz: Annotated[Number, Field(gt=0, le=1e9)] = 5000.0
    """Rate of the control periods (paper, Sec. 4.1: "5 kHz timer")."""
    delay_s: Annotated[Number, Field(ge=0, le=1)] = 0.0
    """Time from taking the sample to applying the amplitude command."""
    jitter_s: Annotated[Number, Field(ge=0, le=1)] = 0.0
    """Chance lateness of the command, |normal| of this standard deviation, at most to the end of its period."""
    lost_ticks: Annotated[Number, Field(ge=0, lt=1)] = 0.0
    """Share of ticks that do not happen: the controller keeps its state and its command."""
    open_until_s: Annotated[Number, Field(ge=0, le=1e6)] = 0.0
    """Until then the loop of a run is open, the lookup alone commands; it closes without a bump (control/law).

    A device is opened and closed by message instead, as the linear analysis has the loop closed.
    """
    form: Literal["float", "firmware"] = "float"
    """The float64 law, or the fixed-point C that runs on the microcontroller (firmware/compiled)."""
    model: Model = Model()
    """What the controller believes of the plant."""

    @model_serializer(mode="wrap")
    def _law_first(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Give the law and its gains before what all controllers have."""
        tree: dict[str, Any] = dump(self)
        return {name: value for name, value in tree.items() if name not in Timing.model_fields} | tree
