"""An effect as it is played, one control period after the other: triggers, direction and what is held have a state."""

from __future__ import annotations

import math
from typing import Self

from frictionloop.parameters.block import Block
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.compiling import program_of
from frictionloop.rendering.effect import TOUCHES_N, Effect
from frictionloop.rendering.playing import KEPT, build_play
from frictionloop.rendering.program import FAR_S, MOST_TRIGGERS, STACK, Program
from frictionloop.rendering.track import Track

PLATE_MM = 255.0
"""Length of the plate (paper, Sec. 4.1)."""


class Player:
    """An effect along a path: give it where the finger is, get the force that is asked for.

    >>> from frictionloop.rendering import Grating, Player
    >>> player = Player(Grating(spacing_mm=2.0), band_n=(0.1, 0.8))
    >>> round(player.tick(along_mm=0.5, speed_mm_s=20.0, load_n=0.5, dt=2e-4), 3)
    0.6

    Parameters
    ----------
    effect : Effect
        What is played.
    track : Track
        Where the stroke runs over it; along x by default.
    band_n : (float, float)
        Least and largest force that is asked for: whatever an effect says is limited to it.
    length_mm : float
        Length of the plate.
    """

    def __init__(
        self,
        effect: Effect,
        track: Track | None = None,
        band_n: tuple[float, float] = (0.0, math.inf),
        length_mm: float = PLATE_MM,
    ) -> None:
        if not isinstance(effect, Block) or not isinstance(effect, Effect):
            raise FrictionloopError(f"effect = {effect!r:.60}: must be an effect")
        if not band_n[0] <= band_n[1]:
            raise FrictionloopError(f"band_n = {band_n!r}: must be two rising forces")
        self._begin(program_of(effect, track or Track(), length_mm), band_n)

    @classmethod
    def of(cls, program: Program, band_n: tuple[float, float] = (0.0, math.inf)) -> Self:
        """Return the player of a program, such as that of the tables which a device is given."""
        player = cls.__new__(cls)
        player._begin(program, band_n)
        return player

    def _begin(self, program: Program, band_n: tuple[float, float]) -> None:
        self.band_n, self.touches_n = band_n, TOUCHES_N
        self._play = build_play(lambda function: function, 1, plain=False)
        self._numbers = program.numbers.tolist()
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self.time_s, self._begins = 0.0, True
        self.clamped_n = 0.0
        """How much the last force was limited, above 0 where more was asked for."""
        self._state = [0.0] * (KEPT - MOST_TRIGGERS) + [FAR_S] * MOST_TRIGGERS + [0.0] * STACK

    def tick(self, along_mm: float, speed_mm_s: float, load_n: float, dt: float) -> float:
        """Return the force in N for where the finger is, and go on by a control period.

        Parameters
        ----------
        along_mm
            Way along the path from its middle, mm.
        speed_mm_s
            Speed along it, mm/s.
        load_n
            Normal force, N; below 0.02 N the finger is in the air, and the force is held.
        dt
            Control period in s.
        """
        touch = along_mm, speed_mm_s, load_n, self.touches_n
        when = self.time_s, self._begins, dt
        force_n, self.clamped_n = self._play(self._state, 0, KEPT, self._numbers, *touch, self.band_n, *when)
        self.time_s, self._begins = self.time_s + dt, False
        return float(force_n)
