"""An effect as it is played, one control period after the other: triggers, direction and what is held have a state.

This is the program's meaning in plain Python; the simulator runs the same in its kernel (loop/kernel/effect_tile).
"""

from __future__ import annotations

import math
from typing import Any

from frictionloop.parameters.block import Block
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect import TOUCHES_N, TURNS_MM_S, Effect
from frictionloop.rendering.program import FAR_S, Do, Program, program_of
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
            raise FrictionloopError(f"effect = {effect!r:.60}: must be an effect, such as fl.rendering.Grating()")
        if not band_n[0] <= band_n[1]:
            raise FrictionloopError(f"band_n = {band_n!r}: must be a least and a largest force")
        self.program: Program = program_of(effect, track or Track(), length_mm)
        self.band_n, self.touches_n = band_n, TOUCHES_N
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self.time_s, self.direction, self.held_n = 0.0, 1.0, math.nan
        self.clamped_n = 0.0
        """How much the last force was limited, above 0 where more was asked for."""
        self.on = [0.0] * self.program.triggers
        self.since_s = [FAR_S] * self.program.triggers

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
        first = math.isnan(self.held_n)
        if abs(speed_mm_s) > TURNS_MM_S:
            self.direction = 1.0 if speed_mm_s > 0.0 else -1.0
        if load_n >= self.touches_n or first:
            raw = self._run(along_mm, speed_mm_s, load_n, first)
            self.held_n = min(max(raw, self.band_n[0]), self.band_n[1])
            self.clamped_n = raw - self.held_n
        self.time_s += dt
        self.since_s = [since + dt for since in self.since_s]
        return self.held_n

    def _run(self, along_mm: float, speed_mm_s: float, load_n: float, first: bool) -> float:
        stack: list[float] = []
        values = self.program.values
        for do, *given in self.program.code:
            if do == Do.TABLE:
                stack.append(_table(values, along_mm, given))
            elif do == Do.WAVE:
                stack.append(self._wave(values, given))
            elif do == Do.TRIGGER:
                stack.append(self._trigger(given, (load_n, abs(speed_mm_s), along_mm), first))
            elif do == Do.DIRECTION:
                stack.append(self.direction)
            elif do == Do.SPEED:
                stack.append(given[0] * abs(speed_mm_s))
            elif do == Do.SCALED:
                stack[-1] *= given[0]
            elif do == Do.MIX:
                other, one, share = stack.pop(), stack.pop(), stack.pop()
                share = min(max(share, 0.0), 1.0)
                stack.append(other + share * (one - other))
            else:
                b, a = stack.pop(), stack.pop()
                stack.append(a + b if do == Do.ADD else a * b if do == Do.MULTIPLY else max(a, b))
        return stack.pop()

    def _wave(self, values: Any, given: list[float]) -> float:
        start, count, rate, loops, trigger, is_on = given
        time = self.time_s
        if trigger >= 0:
            time = self.since_s[int(trigger)]
            if self.on[int(trigger)] != is_on or time >= FAR_S:
                return 0.0
        u = time * rate
        if loops:
            u -= count * math.floor(u / count)
        elif u > count - 1:
            return 0.0
        cell = min(int(u), int(count) - (1 if loops else 2))
        here, after = values[int(start) + cell], values[int(start) + cell + 1]
        return float(here + (u - cell) * (after - here))

    def _trigger(self, given: list[float], quantities: tuple[float, float, float], first: bool) -> float:
        number, kind, on, off, dead = given[:5]
        value, k, high = quantities[int(kind)], int(number), on > off
        now_on = value >= on if high else value <= on
        now_off = value <= off if high else value >= off
        if first:
            self.on[k] = float(now_on)
        elif self.since_s[k] >= dead and (now_off if self.on[k] else now_on):
            self.on[k], self.since_s[k] = 1.0 - self.on[k], 0.0
        return self.on[k]


def _table(values: Any, along_mm: float, given: list[float]) -> float:
    start, count, first_mm, per_mm, nearest, repeats = given
    u = (along_mm - first_mm) * per_mm
    if repeats:
        u -= count * math.floor(u / count)
        last = int(count) - 1
    else:
        u = min(max(u, 0.0), count - 1.0)
        last = int(count) - 2
    if nearest:
        u = math.floor(u + 0.5)
    cell = min(int(u), last)
    here, after = values[int(start) + cell], values[int(start) + cell + 1]
    return float(here + (u - cell) * (after - here))
