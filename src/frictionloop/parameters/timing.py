"""What all controllers have: when they run, and what they believe of the plant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from frictionloop.parameters.block import Block, Number
from frictionloop.parameters.model import Model


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
    """Until then the loop of a run is open, the lookup alone commands; it closes without a bump (control/switch).

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
