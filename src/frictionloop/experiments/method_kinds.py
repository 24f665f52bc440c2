"""The methods as a protocol names them: their numbers, and the handler that they make."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from frictionloop.experiments.adaptive_methods import Psi, Quest, Staircase
from frictionloop.experiments.level_handlers import Adjustment, ConstantStimuli, Handler, Interleaved, Walk
from frictionloop.experiments.trial_structure import Stop
from frictionloop.parameters.block import Block, Kinded, Kinds, NotNegative, Number, Positive, Whole
from frictionloop.quantities import must_be

MOST_TRIALS = 10_000
"""Trials of a method that time alone ends: more than a session has (assumed)."""
Some = Annotated[Whole, Field(ge=1, le=1000)]
Levels = Annotated[tuple[Number, ...], Field(min_length=1, max_length=1000)]


class MethodModel(Kinded):
    """How levels are chosen."""

    ENDS: ClassVar[tuple[str, ...]] = ("low", "high")
    """Fields with the least and the largest level."""

    @model_validator(mode="after")
    def _rises(self) -> Self:
        low, high = self.extremes()
        if self.ENDS and not low < high:
            raise must_be(self.ENDS[1], high, f"above {self.ENDS[0]}, {low:g}")
        return self

    @property
    def scores(self) -> Literal["correct", "comparison"]:
        """What the method is told: whether the answer was right, or whether the comparison was chosen."""
        return "correct"

    def extremes(self) -> tuple[float, float]:
        """Return the least and the largest level that can be asked for."""
        low, high = (float(getattr(self, name)) for name in self.ENDS)
        return low, high

    def handler(self, seed: Any, stop: Stop, guess: float) -> Handler:
        """Return the handler; ``seed`` is what it draws by."""
        raise NotImplementedError


class ConstantMethod(MethodModel):
    """Constant stimuli: each level equally often."""

    ENDS: ClassVar[tuple[str, ...]] = ()
    kind: Literal["constant"] = "constant"
    levels: Levels = (-0.12, -0.08, -0.04, 0.0, 0.04, 0.08, 0.12)
    """Levels; if some are below 0, what counts is whether the comparison was chosen."""
    repeats: Some = 10
    """How often each is asked for."""

    @property
    def scores(self) -> Literal["correct", "comparison"]:
        """Whether the comparison was chosen, where levels lie on both sides of the standard."""
        return "comparison" if min(self.levels) < 0 else "correct"

    def extremes(self) -> tuple[float, float]:
        """Return the least and the largest level."""
        return min(self.levels), max(self.levels)

    def handler(self, seed: Any, stop: Stop, guess: float) -> Handler:
        """Return the handler."""
        return ConstantStimuli(self.levels, self.repeats, seed)


class StaircaseMethod(MethodModel):
    """A staircase, or several that are interleaved and start at different levels."""

    ENDS: ClassVar[tuple[str, ...]] = ("least", "most")
    kind: Literal["staircase"] = "staircase"
    start: Levels = (0.2,)
    """First level; with several there are as many staircases."""
    steps: Annotated[tuple[Positive, ...], Field(min_length=1)] = (2.0, 1.41)
    """Steps down: the first until the first reversal, and so on."""
    unit: Literal["N", "ratio", "dB"] = "ratio"
    """What a step is: added, a factor, or decibels. N is the unit of the level, whatever it is."""
    up: Some = 1
    """Wrong answers in a row to an easier level."""
    down: Some = 2
    """Right answers in a row to a harder level."""
    weight: Positive = 1.0
    """Step up over step down (Kaernbach 1991)."""
    least: Number = 0.005
    """Smallest level."""
    most: Number = 0.3
    """Largest level."""

    @model_validator(mode="after")
    def _starts_inside(self) -> Self:
        if not all(self.least <= each <= self.most for each in self.start):
            raise must_be("start", list(self.start), f"within {self.least:g} to {self.most:g}")
        return self

    def handler(self, seed: Any, stop: Stop, guess: float) -> Handler:
        """Return the handler; a number of trials is shared out over the staircases."""
        share = None if stop.trials is None else -(-stop.trials // len(self.start))
        made = [
            Staircase(
                start, self.steps, self.unit, self.up, self.down, self.weight, self.least, self.most,
                stop.reversals, share or (None if stop.reversals else MOST_TRIALS),
            )
            for start in self.start
        ]  # fmt: skip
        if len(made) == 1:
            return made[0]
        return Interleaved({f"{number + 1}": each for number, each in enumerate(made)}, seed)


class PsiMethod(MethodModel):
    """psi-marginal, whose grid is evenly spaced between its ends."""

    kind: Literal["psi"] = "psi"
    low: Number = 0.005
    """Smallest level, and smallest threshold."""
    high: Number = 0.3
    """Largest level, and largest threshold."""
    levels: Annotated[Whole, Field(ge=2, le=200)] = 40
    """Levels to choose from."""
    thresholds: Annotated[Whole, Field(ge=2, le=400)] = 60
    """Thresholds on the grid."""
    spread: tuple[Positive, Positive] = (0.01, 0.2)
    """Smallest and largest spread."""
    spreads: Annotated[Whole, Field(ge=1, le=100)] = 30
    """Spreads on the grid, evenly spaced in their logarithm."""
    lapses: Annotated[tuple[NotNegative, ...], Field(min_length=1)] = (0.0, 0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.1)
    """Lapse rates on the grid."""
    interest: Literal["threshold", "both"] = "threshold"
    """What is of interest: the threshold alone, or its spread too."""

    def handler(self, seed: Any, stop: Stop, guess: float) -> Handler:
        """Return the handler."""
        return Psi(
            np.linspace(self.low, self.high, self.levels).tolist(),
            np.linspace(self.low, self.high, self.thresholds).tolist(),
            np.geomspace(*self.spread, self.spreads).tolist(),
            self.lapses,
            guess,
            stop.trials if stop.trials or stop.width else MOST_TRIALS,
            stop.width,
            self.interest,
            low=0.0 if guess and self.low >= 0.0 else None,
        )


class QuestMethod(MethodModel):
    """QUEST: the threshold alone, with a spread that is taken as known."""

    kind: Literal["quest"] = "quest"
    low: Number = 0.005
    """Smallest threshold and level."""
    high: Number = 0.3
    """Largest threshold and level."""
    spread: Positive = 0.05
    """Spread of the psychometric function."""
    lapse: NotNegative = 0.02
    """Lapse rate."""

    def handler(self, seed: Any, stop: Stop, guess: float) -> Handler:
        """Return the handler."""
        return Quest(self.low, self.high, self.spread, guess, self.lapse, stop.trials or MOST_TRIALS)


class AdjustmentMethod(MethodModel):
    """The participant turns the level until the two feel alike."""

    kind: Literal["adjustment"] = "adjustment"
    low: Number = -0.15
    """Smallest level."""
    high: Number = 0.15
    """Largest level."""
    step: Positive = 0.02
    """Change by one answer."""
    settings: Some = 5
    """Times that the participant sets the level."""

    def handler(self, seed: Any, stop: Stop, guess: float) -> Handler:
        """Return the handler."""
        return Adjustment(self.low, self.high, self.step, self.settings, seed=seed)


class WalkMethod(MethodModel):
    """A level that wanders, which the participant follows on a scale."""

    kind: Literal["walk"] = "walk"
    low: Number = 0.3
    """Smallest level."""
    high: Number = 0.6
    """Largest level."""
    step: Positive = 0.06
    """Standard deviation of a step."""

    def handler(self, seed: Any, stop: Stop, guess: float) -> Handler:
        """Return the handler."""
        return Walk(self.low, self.high, self.step, stop.trials or MOST_TRIALS, seed)


METHODS = Kinds(
    Block, ConstantMethod, StaircaseMethod, PsiMethod, QuestMethod, AdjustmentMethod, WalkMethod, default="staircase"
)
AnyMethod = Annotated[MethodModel, METHODS]
