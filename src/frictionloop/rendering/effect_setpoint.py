"""An effect as the set-point of a loop."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from frictionloop.parameters.input_signals import Signal
from frictionloop.rendering.effect import AnyEffect, Effect, Track
from frictionloop.rendering.effect_player import program_of
from frictionloop.rendering.effect_program import Program
from frictionloop.rendering.library import LIBRARY


class EffectSource(Signal):
    """f_r(t) is what an effect asks for at the place where the finger is found to be."""

    kind: Literal["effect"] = "effect"
    effect: AnyEffect = LIBRARY["grating"]
    """The effect; or the name of one of the library, or a TOML file with one."""
    position: Literal["measured", "predicted"] = "predicted"
    """Place that it is asked at: the last sample of the position sensor, with its noise; or where its filter finds
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

    @property
    def band_n(self) -> tuple[float, float, float]:
        """Least, mean and largest force along the middle 100 mm of the path, N, on the way forth at 20 mm/s."""
        return _band_n(self.effect, self.track)

    @property
    def offset_n(self) -> float:
        """The mean force, which sums of forces are taken less of."""
        return self.band_n[1]

    def force_n(self, time_s: Any) -> Any:
        """Refuse: a place is needed, and the loop knows it."""
        raise NotImplementedError("an effect is of place: fl.rendering.Player")


@lru_cache(maxsize=256)
def _band_n(effect: Effect, track: Track) -> tuple[float, float, float]:
    force = effect.force_of(track.touch(np.linspace(-50.0, 50.0, 1001), 20.0))
    return float(np.min(force)), float(np.mean(force)), float(np.max(force))
