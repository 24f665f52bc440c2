"""Methods that go by the answers: staircases, psi-marginal on a grid, and QUEST."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from frictionloop.experiments.level_handlers import Handler, Told
from frictionloop.experiments.psychometric import Shape, middle, nothing_there, probability
from frictionloop.quantities import Array, FrictionloopError, must_be
from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.value_checks import numbers, whole


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
            raise must_be("unit", unit, "N, ratio or dB")
        if not self._steps or min(self._steps) <= (1.0 if unit == "ratio" else 0.0):
            raise must_be("steps", list(steps), f"above {(1 if unit == 'ratio' else 0)} {unit}")
        if unit != "N" and not start > 0:
            raise must_be("start", start, "above 0")
        if reversals is None and trials is None:
            raise FrictionloopError("reversals, trials: one is needed")
        self.least, self.most = -math.inf if least is None else least, math.inf if most is None else most
        if not self.least <= start <= self.most:
            raise must_be("start", start, f"{self.least:g} to {self.most:g}")
        self.level = float(start)
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
        step, times = self._step(), self.weight if way > 0 else -1.0
        if self.unit == "N":
            moved = self.level + times * step
        elif self.unit == "dB":
            moved = self.level * 10.0 ** (times * step / 20.0)
        else:
            moved = self.level * step**times
        self.level = min(max(moved, self.least), self.most)


class Psi(Handler):
    """psi-marginal (Prins 2013): the level whose answer tells most, on average, of the parameters of interest.

    The posterior of threshold a, spread b and lapse rate l is kept on a grid; the expected entropy is that of the
    marginal of what is of interest. With both threshold and spread it is psi (Kontsevich & Tyler 1999). It is the
    method of QUEST+ with these three parameters (Watson 2017).

    Parameters
    ----------
    levels : sequence of float
        Levels to choose from.
    threshold, spread, lapse : sequence of float
        Values on the grid, with a flat prior but for ``low``.
    guess : float
        Probability of a right answer without a stimulus.
    trials : int
        Where it ends.
    width : float, optional
        Width of the 95 % interval of the threshold at which it ends before.
    interest : {"threshold", "both"}
        What is of interest besides the threshold: nothing, or the spread.
    shape : str
        Psychometric function, as of `probability`.
    low : float, optional
        Level at which nothing is there to be told, as of `fit`.
    """

    def __init__(
        self,
        levels: Sequence[float],
        threshold: Sequence[float],
        spread: Sequence[float],
        lapse: Sequence[float] = (0.0, 0.02, 0.05),
        guess: float = 0.5,
        trials: int | None = 60,
        width: float | None = None,
        interest: Literal["threshold", "both"] = "threshold",
        shape: Shape = "normal",
        low: float | None = None,
    ) -> None:
        super().__init__()
        if trials is None and width is None:
            raise FrictionloopError("trials, width: one is needed")
        self.levels = numbers("levels", levels, "")
        self._trials, self._width, self.guess, self.shape = trials, width, guess, shape
        grids = [numbers(*each, "") for each in (("threshold", threshold), ("spread", spread), ("lapse", lapse))]
        self._grids = tuple(grids)
        size = tuple(each.size for each in grids)
        self._a, self._b, self._l = np.meshgrid(*grids, indexing="ij", sparse=True)
        prior = np.ones(size) if low is None else np.exp(nothing_there(low, self._a, self._b, shape)) + np.zeros(size)
        self.posterior: Array = prior / prior.sum()
        """Probability of each (threshold, spread, lapse)."""
        self._kept = size[0] if interest == "threshold" else size[0] * size[1]
        # (of interest, levels, nuisance): a sum over the nuisance is then a product of matrices.
        table = np.stack([self._right(x) for x in self.levels.tolist()])
        table = np.moveaxis(table, 0, 1 if interest == "threshold" else 2)
        self._table = np.ascontiguousarray(table.reshape(self._kept, self.levels.size, -1))
        self.level = self._best()

    @property
    def finished(self) -> bool:
        """Whether the trials are done, or the threshold is known well enough."""
        if self._trials is not None and len(self.told) >= self._trials:
            return True
        low, high = self.interval() if self._width is not None and self.told else (-math.inf, math.inf)
        return self._width is not None and high - low <= self._width

    @property
    def state(self) -> str:
        """Median and standard deviation of the threshold's posterior."""
        median, sd = self.estimate()
        return f"threshold={median:.5g} sd={sd:.3g}"

    def estimate(self) -> tuple[float, float]:
        """Return median and standard deviation of the threshold."""
        marginal, values = self.posterior.sum(axis=(1, 2)), self._grids[0]
        sd = math.sqrt(max(float(marginal @ values**2 - (marginal @ values) ** 2), 0.0))
        return middle(marginal, values)[0], sd

    def interval(self) -> tuple[float, float]:
        """Return the 95 % interval of the threshold."""
        return middle(self.posterior.sum(axis=(1, 2)), self._grids[0])[1:]

    def expected_entropy(self) -> Array:
        """Return the expected entropy after the next answer, in nats, of each level."""
        post = self.posterior.reshape(self._kept, -1, 1)
        right = np.matmul(self._table, post)[:, :, 0]
        wrong = post.sum(axis=1) - right
        return _entropy(right) + _entropy(wrong)

    def _best(self) -> float:
        return float(self.levels[int(np.argmin(self.expected_entropy()))])

    def _right(self, x: float) -> Array:
        return probability(x, self._a, self._b, self.guess, self._l, self.shape)

    def _next(self, told: Told) -> None:
        right = self._right(told.delivered)
        post = self.posterior * (right if told.result > 0 else 1.0 - right)
        # An answer that no point of the grid could give tells nothing.
        if (total := float(post.sum())) > 0.0:
            self.posterior = post / total
        self.level = self._best()


def _entropy(joint: Array) -> Array:
    """Return p(answer) times the entropy of the parameters after it, from the joint (parameters, levels)."""
    total = joint.sum(axis=0)
    inside = np.where(joint > 0.0, joint * np.log(np.maximum(joint, 1e-300)), 0.0).sum(axis=0)
    return np.asarray(total * np.log(np.maximum(total, 1e-300)) - inside)


class Quest(Handler):
    """QUEST (Watson & Pelli 1983), by the package SweetSpot: asks for a fixed quantile of the threshold's posterior.

    Parameters
    ----------
    low, high : float
        Ends of the thresholds that are thought possible.
    spread : float
        Spread of the psychometric function, taken as known.
    guess, lapse : float
        Its ends, taken as known.
    trials : int
        Where it ends.
    points : int
        Thresholds on the grid.

    Raises
    ------
    FrictionloopError
        If SweetSpot is missing.
    """

    def __init__(
        self,
        low: float,
        high: float,
        spread: float,
        guess: float = 0.5,
        lapse: float = 0.02,
        trials: int = 40,
        points: int = 201,
    ) -> None:
        super().__init__()
        quest: Any = needed("SweetSpot", "sweetspot", "experiments").QUEST
        # The logarithm of the slope in the middle, as steep as that of a normal distribution with this spread.
        beta = -math.log(math.sqrt(2.0 * math.pi) * spread)
        self._quest = quest(
            beta, gamma=guess, lambda_=lapse, alphaGrid=(low, high, points), maxIterations=trials, estimator="AVG"
        )
        self.level = float(self._quest.PendingValue())

    @property
    def finished(self) -> bool:
        """Whether the trials are done."""
        return bool(self._quest.Finished())

    @property
    def state(self) -> str:
        """Mean of the threshold's posterior."""
        return f"threshold={self.estimate():.5g}"

    def estimate(self) -> float:
        """Return the mean of the threshold's posterior."""
        return float(np.ravel(self._quest.Estimate())[0])

    def _next(self, told: Told) -> None:
        following = self._quest.Observe(int(told.result > 0), x=told.delivered)
        if following is not None:
            self.level = float(following)
