"""What of a protocol is not its stimuli: conditions, the course of a trial, blocks, stopping, validity."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from frictionloop.parameters.block import Block, NotNegative, Number, Positive, Whole
from frictionloop.quantities import must_be

Share = Annotated[Number, Field(ge=0, le=1)]
Count = Annotated[Whole, Field(ge=0, le=100_000)]


class Condition(Block):
    """One of the conditions that each participant goes through, such as a control law."""

    name: Annotated[str, Field(pattern=r"^[a-z0-9_-]+$")]
    """Name in tables."""
    system: dict[str, Any] = Field(default_factory=dict)
    """What differs in the system, by dotted name, such as controller.kind = "lookup"."""
    effect: dict[str, Any] = Field(default_factory=dict)
    """What differs in the effect, by dotted name, such as spacing_mm = 4."""


class StrokeGuide(Block):
    """One stroke as the participant is asked to make it."""

    direction: Literal["forth", "back", "both"] = "forth"
    """Way along the plate; both is forth and back."""
    length_mm: Positive = 30.0
    """Way of one stroke (assumed)."""
    speed_mm_s: Positive = 20.0
    """Speed that the guide shows (paper, Sec. 4.2)."""
    load_n: Positive = 0.5
    """Load that the guide shows (0.49 N: Smith 2002)."""

    @property
    def duration_s(self) -> float:
        """Time of the stroke at the guide's speed."""
        return (2.0 if self.direction == "both" else 1.0) * self.length_mm / self.speed_mm_s


class Timeline(Block):
    """The course of a trial: a cue, a stroke in each interval, the time to answer, feedback."""

    cue_s: NotNegative = 0.5
    """Time from the cue to the first stroke (assumed)."""
    stroke: StrokeGuide = StrokeGuide()
    """Stroke of each interval."""
    gap_s: NotNegative = 0.5
    """Time between two intervals; the finger goes back in it (assumed)."""
    response_s: Positive = 5.0
    """Time in which an answer counts, from the end of the last stroke (assumed)."""
    feedback: bool = False
    """Whether the participant is told if the answer was right; in practice they always are."""


class Blocks(Block):
    """How the trials of a condition are ordered and divided."""

    order: Literal["latin", "given", "random"] = "latin"
    """Order of the conditions: a balanced Latin square over participants, as given, or drawn for each participant."""
    practice: Count = 0
    """Practice trials before each condition; they count for nothing."""
    practice_level: Number | None = None
    """Level of a practice trial; the largest one if not given."""
    break_every: Count = 0
    """Trials between two breaks; 0 is without breaks."""
    catch_share: Share = 0.0
    """Share of trials whose level anybody tells (``catch_level``); the method is not told of them."""
    catch_level: Number | None = None
    """Level of a catch trial; the largest one if not given."""


class Stop(Block):
    """When a condition is over: when the first of these holds, or the method ends by itself."""

    trials: Annotated[Whole, Field(ge=1, le=10_000)] | None = None
    """Trials that counted."""
    reversals: Annotated[Whole, Field(ge=1, le=1000)] | None = None
    """Reversals, of a staircase alone."""
    width: Positive | None = None
    """Width of the 95 % interval of the threshold's posterior, in the unit of the level, of psi alone."""
    time_s: Positive | None = None
    """Time on the device clock."""


Range = tuple[Number, Number]


class Validity(Block):
    """What a stroke must be for its trial to count, and what happens if it is not."""

    speed_mm_s: Range = (10.0, 40.0)
    """Least and largest mean speed where the force is scored (assumed: half and twice the guide's)."""
    load_n: Range = (0.2, 1.5)
    """Least and largest mean load (assumed)."""
    contact_share: Share = 0.4
    """Least share of the stroke that is scored: the finger slides and is down (assumed)."""
    saturated_share: Share = 0.5
    """Largest share of scored periods with a clamped command (assumed)."""
    rms_error_n: Positive | None = None
    """Largest rms error of the force; left out it is any."""
    lost_samples: Count = 0
    """Most samples that may be lost."""
    least_response_s: NotNegative = 0.1
    """Least response time: no answer to a stroke that is felt comes sooner (Luce 1986: 0.1 s)."""
    then: Literal["repeat", "mark"] = "repeat"
    """Repeat the trial, or keep it with a mark and go on."""
    repeats: Count = 3
    """Most repetitions of one trial, which is then kept with a mark (assumed)."""

    @field_validator("speed_mm_s", "load_n")
    @classmethod
    def _rises(cls, value: Range) -> Range:
        if not value[0] < value[1]:
            raise ValueError("must be two rising values")
        return value


ENDS_ITSELF = ("constant", "adjustment")
"""Methods that need no rule by which they stop."""


def check_stop(stop: Stop, method: str) -> None:
    """Refuse a rule that a method does not know, and a method that never ends.

    Raises
    ------
    ValueError
        Naming the rule.
    """
    for name, only in (("reversals", "staircase"), ("width", "psi")):
        value = getattr(stop, name)
        if value is not None and method != only:
            raise ValueError(f'stop.{name} = {value:g}: goes with method.kind = "{only}"')
    if method not in ENDS_ITSELF and not stop.model_dump(exclude_none=True):
        raise must_be("stop", None, "trials, reversals, width or time_s")


def check_guide(stroke: StrokeGuide, rules: Validity) -> None:
    """Refuse a guide that asks for strokes that do not count.

    Raises
    ------
    ValueError
        Naming what it asks for, and what counts.
    """
    for name in ("speed_mm_s", "load_n"):
        asked, (low, high) = getattr(stroke, name), getattr(rules, name)
        if not low <= asked <= high:
            raise must_be(f"timeline.stroke.{name}", asked, f"{low:g} to {high:g} (validity)")
