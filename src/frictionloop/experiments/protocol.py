"""A protocol: one frozen value that says what an experiment is, from a TOML file or from Python."""

from __future__ import annotations

import os
from importlib import resources
from pathlib import Path as File
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from frictionloop.experiments.method_kinds import AnyMethod, StaircaseMethod
from frictionloop.experiments.trial_structure import (
    ENDS_ITSELF,
    Blocks,
    Condition,
    Stop,
    Timeline,
    Validity,
    check_guide,
    check_stop,
)
from frictionloop.findings import Result
from frictionloop.parameters.block import Block, Number, Whole
from frictionloop.parameters.frozen_blocks import Description
from frictionloop.parameters.toml_reader import read_tree
from frictionloop.parameters.toml_writer import block_toml
from frictionloop.quantities import FrictionloopError, check_known, must_be, replacing, unit_of
from frictionloop.rendering.effect import AnyEffect, Effect
from frictionloop.rendering.effect_toml import changed
from frictionloop.rendering.library import LIBRARY

Task = Literal["2ifc", "2afc", "yes_no", "same_different", "magnitude", "adjustment", "tracking"]
INTERVALS = {"yes_no": 1, "magnitude": 1, "tracking": 1}
"""Intervals of a trial, two where a task is not named here."""
CHOICES = {
    "2ifc": ("1", "2"),
    "2afc": ("left", "right"),
    "yes_no": ("yes", "no"),
    "same_different": ("same", "different"),
    "adjustment": ("less", "more", "alike"),
}
"""Answers of a task; a number is the answer where a task is not named here."""


class Stimulus(Block):
    """An effect with one free number, the level."""

    effect: AnyEffect = LIBRARY["constant"]
    """The effect."""
    field: str = "level_n"
    """Dotted name of the field of the effect that the level enters."""
    standard: Number | None = None
    """Value of that field in the standard; left out where a trial has no standard."""
    adds: bool = True
    """Whether the level is added to the standard; else the field is the level itself."""
    delivered: Literal["declared", "mean", "contrast", "asked"] = "declared"
    """What is taken as delivered of it: the mean force, how much of the pattern is in it, or what was asked; declared
    takes what fits the effect."""

    def value(self, level: float | None) -> float:
        """Return the value of the field at a level; None is the standard."""
        if level is None:
            if self.standard is None:
                raise must_be("stimulus.standard", None, "a number")
            return self.standard
        return level + (self.standard or 0.0) if self.adds else level

    def at(self, level: float | None, changes: dict[str, Any] | None = None) -> Effect:
        """Return the effect at a level, None being the standard, with a condition's changes.

        Raises
        ------
        FrictionloopError
            For a field that the effect does not have, or a value that it does not take.
        """
        return changed(self.effect, {**(changes or {}), self.field: self.value(level)})


class Protocol(Description):
    """An experiment on the friction that is felt."""

    name: Annotated[str, Field(pattern=r"^[a-z0-9-]+$")] = "experiment"
    """Name in files."""
    title: str = ""
    """One line that says what is measured."""
    question: str = "Which felt rougher?"
    """What the participant is asked after each trial."""
    task: Task = "2ifc"
    """What a trial is and which answers there are."""
    attribute: Literal["friction", "pattern", "spacing"] = "friction"
    """What of the force the participant judges: its level, how strong a pattern is, or how wide."""
    level_unit: str = "N"
    """Unit of the level, in tables and figures; that of the stimulus's field if not given."""
    seed: Annotated[Whole, Field(ge=0, lt=2**63)] = 0
    """Seed of everything that is drawn."""
    stimulus: Stimulus = Stimulus(standard=0.45)
    """Effect, its free level, and the standard."""
    method: AnyMethod = StaircaseMethod()
    """How levels are chosen."""
    timeline: Timeline = Timeline()
    """Course of a trial."""
    blocks: Blocks = Blocks()
    """Order, practice, breaks and catch trials."""
    stop: Stop = Stop(trials=60)
    """When a condition is over; without any, a method that has no end of its own ends after 60 trials that counted."""
    validity: Validity = Validity()
    """What a stroke must be to count."""
    fit_to_finger: bool = True
    """Whether two plain strokes before the session tell the controller the participant's friction."""
    out_of_reach: Literal["fit", "refuse", "mark"] = "fit"
    """What happens to levels that these strokes show to be out of reach: they are drawn together until all can be
    given, the session is refused, or they stay and validity marks them."""
    blind: bool = True
    """Whether the experimenter's page hides condition, level, set-point and answers while the session runs."""
    masking_db: Annotated[Number, Field(ge=-60, le=0)] | None = None
    """Masking noise on the participant's page against the plate's sound, dB under full scale; left out it is silent."""
    conditions: tuple[Condition, ...] = (Condition(name="closed"),)
    """Conditions that each participant goes through."""
    system: dict[str, Any] = Field(default_factory=dict)
    """What differs from the bench's system in all conditions, by dotted name."""

    @property
    def intervals(self) -> int:
        """Strokes of a trial."""
        return INTERVALS.get(self.task, 2)

    @property
    def choices(self) -> tuple[str, ...]:
        """Answers there are; none if the answer is a number."""
        return CHOICES.get(self.task, ())

    @property
    def guess(self) -> float:
        """Probability of a right answer that is guessed: 1/2 with two intervals, else 0."""
        return 0.5 if self.task in ("2ifc", "2afc") and self.method.scores == "correct" else 0.0

    @model_validator(mode="before")
    @classmethod
    def _defaults(cls, given: Any) -> Any:
        """Give the level the unit of its field; constant stimuli and adjustment end by themselves, without trials."""
        stimulus = given.get("stimulus") if isinstance(given, dict) else None
        field = stimulus.get("field", "") if isinstance(stimulus, dict) else getattr(stimulus, "field", "")
        if unit_of(field) and "level_unit" not in given:
            given = given | {"level_unit": unit_of(field)}
        if isinstance(given, dict) and "stop" not in given:
            method = given.get("method")
            kind = method.get("kind") if isinstance(method, dict) else getattr(method, "kind", None)
            if kind in ENDS_ITSELF:
                return given | {"stop": Stop()}
        return given

    @model_validator(mode="after")
    def _fits(self) -> Self:
        check_stop(self.stop, self.method.kind)
        check_guide(self.timeline.stroke, self.validity)
        if not self.question.strip():
            raise must_be("question", self.question, "what is asked")
        names = [each.name for each in self.conditions]
        if not names or len(set(names)) < len(names):
            raise must_be("conditions", names, "names that differ")
        if (unit := unit_of(self.stimulus.field)) and self.level_unit != unit:
            raise must_be("level_unit", self.level_unit, f"{unit}, as {self.stimulus.field}")
        least = self.stimulus.value(self.method.extremes()[0])
        if least < 0.0 and self.attribute == "pattern":
            raise must_be(self.stimulus.field, least, "0 or more: a pattern's strength has no sign")
        if least <= 0.0 and self.task == "magnitude":
            raise must_be(self.stimulus.field, least, "above 0 for task 'magnitude'")
        if self.intervals == 2 and self.stimulus.standard is None:
            raise must_be("stimulus.standard", None, "a number")
        if (self.task == "adjustment") != (self.method.kind == "adjustment"):
            accepted = "adjustment" if self.task == "adjustment" else "another than adjustment"
            raise must_be("method.kind", self.method.kind, f"{accepted} for task {self.task!r}")
        if self.task in ("magnitude", "tracking") and self.method.kind not in ("constant", "walk"):
            raise must_be("method.kind", self.method.kind, f"constant or walk for task {self.task!r}")
        for condition in self.conditions:
            for level in self.method.extremes():
                try:
                    self.stimulus.at(level, condition.effect)
                except FrictionloopError as error:
                    raise ValueError(f"stimulus at level {level:g}, condition {condition.name}: {error}") from None
        return self


def read_protocol(name: str | os.PathLike[str]) -> Protocol:
    """Return the protocol of a TOML file, or one that comes with the package, by its name.

    Parameters
    ----------
    name : str or path
        A file, or one of `bundled`.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or what is wrong in it, naming file, field and value.
    """
    if isinstance(name, str) and not name.endswith(".toml") and os.sep not in name:
        check_known("protocol", [name], bundled())
        with resources.as_file(_FOLDER / f"{name}.toml") as path:
            return Protocol.from_tree(read_tree(path), f"{name}: ")
    return Protocol.from_tree(read_tree(name), f"{name}: ")


def bundled() -> list[str]:
    """Return the names of the protocols that come with the package."""
    return sorted(each.name.removesuffix(".toml") for each in _FOLDER.iterdir() if each.name.endswith(".toml"))


def to_toml(of: Protocol) -> str:
    """Return a protocol as TOML text, each key with its unit, meaning and what it accepts as a comment."""
    return block_toml(of, form=True)


class NewProtocol(Result, schema="experiments.new/1"):
    """A protocol that was written."""

    protocol: Protocol
    path: File

    def rows(self) -> list[tuple[str, str]]:
        """Return what it is, and the command that checks it."""
        return [("protocol", self.protocol.title), ("check", f"frictionloop experiment check {self.path}")]


def new(path: str | os.PathLike[str], start: str = "jnd-friction-staircase") -> NewProtocol:
    """Write a protocol to begin with, each key with its unit, meaning and what it accepts.

    Parameters
    ----------
    path
        File to write (.toml).
    start
        The protocol to copy: a file, or a name of one that comes with the package.

    Raises
    ------
    FrictionloopError
        For a protocol that is not there, or a file that cannot be written.
    """
    found = read_protocol(start)
    with replacing(path) as beside:
        beside.write_text(to_toml(found), encoding="utf-8")
    return NewProtocol(protocol=found, path=File(path))


_FOLDER = resources.files("frictionloop.experiments") / "protocols"
