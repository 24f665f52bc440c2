"""An effect as the set-point of a loop."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, Literal

from frictionloop.parameters.sources import Signal
from frictionloop.rendering.effect import AnyEffect
from frictionloop.rendering.library import LIBRARY
from frictionloop.rendering.track import Track
from frictionloop.rendering.program import Program, program_of


class EffectSource(Signal):
    """f_r(t) is what an effect asks for at the place where the finger is found to be."""

    kind: Literal["effect"] = "effect"
    effect: AnyEffect = LIBRARY["grating"]
    """The effect; or the name of one of the library, or a TOML file with one."""
    position: Literal["measured", "predicted"] = "predicted"
    """Place that it is asked at: the last sample of the position sensor, with its noise; or where its tracker finds
    the finger to be in the middle of the period in which the command is in force."""
    track: Track = Track()
    """Where the stroke runs over the effect."""

    def program(self, length_mm: float) -> Program:
        """Return the effect compiled for a plate of this length."""
        return program_of(self.effect, self.track, length_mm)

    @property
    def longest_s(self) -> float:
        """An effect has no end."""
        return math.inf

    @cached_property
    def offset_n(self) -> float:
        """Mean of its tables over the path, N: what sums of forces are taken less of."""
        import numpy as np

        along = np.linspace(-50.0, 50.0, 1001)
        return float(np.mean(self.effect.asked(self.track.touch(along))))

    def force_n(self, time_s: Any) -> Any:
        """Refuse: a place is needed, and the loop knows it."""
        raise NotImplementedError("an effect has a force at a place; fl.rendering.Player gives it")
