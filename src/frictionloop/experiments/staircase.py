"""Staircases: n up, m down, with weighted steps in the level's unit, as factors or in decibels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from frictionloop.experiments.methods import Handler, Told
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import numbers, whole


class Staircase(Handler):
    """n up, m down, with weighted steps (Kaernbach 1991): easier after n wrong answers, harder after m right ones.

        x <- x + s_up after n wrong,  x <- x - s_down after m right;  as factors, or decibels of 20 log10, if so asked

    With n = 1 it settles where p^m = s_up / (s_up + s_down): 70.7 % for 1 up, 2 down with equal steps.

    Parameters
    ----------
    start : float
        First level.
    steps : sequence of float
        Steps down in ``unit``: the first until the first reversal, and so on; the last one stays.
    unit : {"N", "ratio", "dB"}
        N adds the step, in whatever unit the level has; ratio multiplies by it, and must be above 1.
    up, down : int
        Wrong answers in a row to an easier level, and right ones to a harder level.
    weight : float
        Step up over step down.
    least, most : float, optional
        Ends of the levels.
    reversals, trials : int, optional
        Where it ends, whichever is first.
    """

    def __init__(
        self,
        start: float,
        steps: Sequence[float] = (0.05,),
        unit: Literal["N", "ratio", "dB"] = "N",
        up: int = 1,
        down: int = 2,
        weight: float = 1.0,
        least: float | None = None,
        most: float | None = None,
        reversals: int | None = 8,
        trials: int | None = None,
    ) -> None:
        super().__init__()
        self._steps = [float(each) for each in numbers("steps", steps, unit)]
        self.unit, self.up, self.down, self.weight = unit, whole("up", up, 1), whole("down", down, 1), weight
        if unit not in ("N", "ratio", "dB"):
            raise FrictionloopError(f"unit = {unit!r}: must be N, ratio or dB")
        if not self._steps or min(self._steps) <= (1.0 if unit == "ratio" else 0.0):
            raise FrictionloopError(f"steps = {list(steps)}: must be above {1 if unit == 'ratio' else 0} {unit}")
        if unit != "N" and not start > 0:
            raise FrictionloopError(f"start = {start:g}: must be above 0")
        if reversals is None and trials is None:
            raise FrictionloopError("reversals, trials: one is needed")
        self.least, self.most = -math.inf if least is None else least, math.inf if most is None else most
        self.level = min(max(float(start), self.least), self.most)
        self._reversals, self._trials = reversals, trials
        self._row, self._way = 0, 0  # answers of one kind in a row, wrong ones negative; last way, 1 is up
        self.turned: list[float] = []
        """Levels at which the staircase turned."""

    @property
    def finished(self) -> bool:
        """Whether the reversals or the trials are done."""
        many = self._reversals is not None and len(self.turned) >= self._reversals
        return many or (self._trials is not None and len(self.told) >= self._trials)

    @property
    def state(self) -> str:
        """Reversals so far, and the step in force."""
        return f"reversals={len(self.turned)} step={self._step():g}"

    @property
    def target(self) -> float:
        """Share of right answers where a staircase that needs one wrong answer to go up settles."""
        return float((self.weight / (1.0 + self.weight)) ** (1.0 / self.down))

    def estimate(self, last: int = 6) -> float:
        """Return the mean of the last reversals, as many as make pairs; of factors the geometric mean; NaN without."""
        some = self.turned[len(self.turned) % 2 :][-last:]
        if not some:
            return math.nan
        return float(np.mean(some) if self.unit == "N" else np.exp(np.mean(np.log(some))))

    def _step(self) -> float:
        return self._steps[min(len(self.turned), len(self._steps) - 1)]

    def _next(self, told: Told) -> None:
        right = told.result > 0
        self._row = max(self._row, 0) + 1 if right else min(self._row, 0) - 1
        way = -1 if self._row >= self.down else 1 if self._row <= -self.up else 0
        if not way:
            return
        if self._way and way != self._way:
            self.turned.append(self.level)
        self._row, self._way = 0, way
        step = self._step() * (self.weight if way > 0 else 1.0)
        if self.unit == "N":
            moved = self.level + way * step
        elif self.unit == "dB":
            moved = self.level * 10.0 ** (way * step / 20.0)
        else:
            moved = self.level * self._step() ** (way * (self.weight if way > 0 else 1.0))
        self.level = min(max(moved, self.least), self.most)
