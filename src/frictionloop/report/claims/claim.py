"""A claim of the paper as data: what is printed, what comes out here, what counts as agreement, and the verdict."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache
from importlib.resources import files
from typing import Any, TypeVar

from frictionloop.report.beyond import ORACLE
from frictionloop.report.numbers import number
from frictionloop.report.protocol import IDEAL, PRINTED
from frictionloop.report.results import variants
from frictionloop.report.systems import FEASIBLE
from frictionloop.report.tolerances import YARDSTICKS

THESIS = "pi-reduces-variability"
"""The paper's thesis, which comes first."""
SOME_READINGS = "under some readings"
"""Words for a verdict ASSUMED that some readings of the text give, and others do not."""
T = TypeVar("T")
Value = float | None
"""A computed number; None where what was looked for does not exist."""


class Verdict(StrEnum):
    """What the numbers say about a claim."""

    COMES_OUT = "comes out"
    """Every reading of the text gives an accepted number."""
    ASSUMED = "under an assumption"
    """Some reading does, or something assumed where the text is silent."""
    NOT_OUT = "does not come out"
    """Nothing does."""
    NOT_COUNTED = "not counted"


class Group(StrEnum):
    """Where a claim is counted (docs/paper-notes, "How a verdict is given"), in the order of the page."""

    PRINTED = "come out of the text as printed"
    ASSUMED = "come out under some readings or an assumption"
    NOT_OUT = "do not come out"
    DEVICE = "about the device, on an assumed bench"
    CONSTRUCTION = "decided by construction"
    ARITHMETIC = "arithmetic of the text"
    SLIP = "slips of the text"
    QUESTION = "questions of our own"


COUNTED = (Group.PRINTED, Group.ASSUMED, Group.NOT_OUT, Group.DEVICE)
OF_TEXT = {
    Verdict.COMES_OUT: Group.PRINTED,
    Verdict.ASSUMED: Group.ASSUMED,
    Verdict.NOT_OUT: Group.NOT_OUT,
}


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One statement of the paper beside the number computed for it."""

    id: str
    title: str
    """The statement in a few words."""
    place: str
    """Section and figure of the paper."""
    quote: str
    """The words printed."""
    published: float | str
    """The number printed, or the word where there is none."""
    unit: str = ""
    measure: str
    """What the number is, where title and unit do not say."""
    of: Group | None = None
    """Group of a claim that is not of the simulation, where the verdict decides."""
    note: int
    """Note of docs/paper-notes that says how the text was read."""
    quantity: str
    """What ``ours`` is, in a few words for a table."""
    readings: Mapping[str, Value]
    """The computed number under each reading of the text; the working reading is first.

    A claim of the device is read with gains that are stable on the bench.
    """
    accepted: tuple[float, float]
    """Numbers that agree with the claim, both ends included: set by a rule, never by the result."""
    tolerance: str
    """Where ``accepted`` comes from."""
    explanation: str
    assumed: Mapping[str, Value] = field(default_factory=dict)
    """The number for what the text leaves open: a reachable set-point, a delay, an ideal sensor without delay.

    These can help a claim, not harm it.
    """
    compared: Mapping[str, Value] = field(default_factory=dict)
    """The number of what is shown beside them and has no vote, such as gains that ring on the bench."""
    meant: str = ""
    """Of a slip: what must have been meant."""
    digits: int = 3
    """Digits of the numbers where they are shown."""
    seeds: str = ""
    """Of the runs that its numbers come from."""
    told: Mapping[str, float | str] = field(default_factory=dict)
    """Numbers that the explanation, or the page's text, names besides."""

    @property
    def ours(self) -> Value:
        """The number under the working reading."""
        return next(iter(self.readings.values()))

    @property
    def command(self) -> str:
        """The command line that computes the numbers again."""
        return f"frictionloop reproduce --only {self.id}"

    @property
    def holds(self) -> dict[str, bool]:
        """Whether the number of each reading, assumption and comparison is accepted."""
        low, high = self.accepted
        return {name: value is not None and low <= value <= high for name, value in self.all_values.items()}

    @property
    def all_values(self) -> dict[str, Value]:
        """Readings, assumptions and comparisons together."""
        return {**self.readings, **self.assumed, **self.compared}

    @property
    def under(self) -> list[str]:
        """Readings and assumptions whose numbers are accepted."""
        return [name for name in (*self.readings, *self.assumed) if self.holds[name]]

    @property
    def result(self) -> Verdict:
        """What readings and assumptions decide, whether it is counted or not."""
        if all(self.holds[name] for name in self.readings):
            return Verdict.COMES_OUT
        return Verdict.ASSUMED if self.under else Verdict.NOT_OUT

    @property
    def judged(self) -> str:
        """The verdict in words, which tell readings of the text from assumptions where it is silent."""
        read = self.verdict is Verdict.ASSUMED and set(self.under) & set(self.readings)
        return SOME_READINGS if read else str(self.verdict)

    @property
    def verdict(self) -> Verdict:
        """What is told of the claim."""
        return self.result if self.group in COUNTED else Verdict.NOT_COUNTED

    @property
    def group(self) -> Group:
        """Where it is counted."""
        return self.of or OF_TEXT[self.result]

    def to_dict(self) -> dict[str, Any]:
        """Return the claim for JSON: an end of ``accepted`` that is infinite becomes null."""
        words = ("id", "title", "place", "quote", "published", "ours", "unit", "measure", "quantity")
        more = ("under", "meant", "note", "explanation", "seeds", "command")
        return {
            **{name: getattr(self, name) for name in words},
            **{name: dict(getattr(self, name)) for name in ("readings", "assumed", "compared")},
            "tolerance": {"accepted": [_finite(end) for end in self.accepted], "from": self.tolerance},
            "group": str(self.group),
            "verdict": self.judged,
            **{name: getattr(self, name) for name in more},
        }


def having(values: Mapping[str, T], names: Collection[str]) -> dict[str, T]:
    """Return the entries of which a part of the name, between commas, is one of ``names``, which may have commas."""
    return {name: value for name, value in values.items() if any(f", {each}, " in f", {name}, " for each in names)}


def lacking(values: Mapping[str, T], names: Collection[str]) -> dict[str, T]:
    """Return the other entries."""
    kept = having(values, names)
    return {name: value for name, value in values.items() if name not in kept}


def _finite(value: float) -> Value:
    return value if math.isfinite(value) else None


OPEN_TO_ASSUME = (FEASIBLE, *variants(), IDEAL)
"""What the text leaves open: numbers with one of these in their name vote as assumptions."""
WITHOUT_VOTE = (PRINTED, ORACLE)
"""On the bench: gains that ring there, and a law that nobody can build."""
FILLED = ("measure", "explanation", "meant")
"""Texts in which ``{name}`` stands for a number."""


class Told(float):
    """A number in a text: ``{name}`` has three digits, ``{name:2}`` two, ``{name:.0%}`` is what it is in Python.

    ``{name:m}`` and ``{name:2m}`` are in thousandths.
    """

    def __format__(self, spec: str) -> str:
        """Return the number for people."""
        told = re.fullmatch(r"(\d?)(m?)", spec)
        return number((1e3 if told[2] else 1.0) * self, int(told[1] or 3)) if told else format(float(self), spec)


@dataclass(frozen=True)
class Numbers:
    """What is computed for a claim."""

    readings: Mapping[str, Value]
    assumed: Mapping[str, Value]
    compared: Mapping[str, Value]
    told: Mapping[str, Told | str]
    """Numbers that its texts name besides."""


def numbers(
    values: Mapping[str, Value],
    *,
    assumed: Collection[str] = (),
    compared: Collection[str] = (),
    **told: float | str | None,
) -> Numbers:
    """Return the numbers of a claim, sorted by what is in their names: readings, assumptions, mere comparisons.

    ``assumed`` and ``compared`` are parts of names that this claim alone sorts so; ``told`` is for its texts, which may
    name the values too: ``{reachable set-point}``.
    """
    voting = lacking(values, (*WITHOUT_VOTE, *compared))
    open_ends = (*OPEN_TO_ASSUME, *assumed)
    return Numbers(
        lacking(voting, open_ends),
        having(voting, open_ends),
        having(values, (*WITHOUT_VOTE, *compared)),
        {name: _told(each) for name, each in told.items()},
    )


def _told(value: float | str | None) -> Told | str:
    return value if isinstance(value, str) else Told(math.nan if value is None else value)


@cache
def texts(topic: str) -> Mapping[str, dict[str, Any]]:
    """Return the texts of a topic's claims, by their ids, in order."""
    found: dict[str, dict[str, Any]] = tomllib.loads(
        (files("frictionloop.report.claims") / f"{topic}.toml").read_text(encoding="utf-8")
    )
    return found


def judged(id: str, text: Mapping[str, Any], found: Numbers, seeds: str) -> Claim:
    """Return the claim of a text and the numbers computed for it."""
    words = {name: value for name, value in text.items() if name not in ("group", "yardstick", "against")}
    given = {name: _told(each) for name, each in {**found.readings, **found.assumed, **found.compared}.items()}
    words |= {name: words[name].format_map({**given, **found.told}) for name in FILLED if name in words}
    rules = [words.pop("tolerance")] if "tolerance" in words else []
    if "yardstick" in text:
        yardstick = YARDSTICKS[text["yardstick"]]
        words["accepted"] = yardstick.accepted(text.get("against", text["published"]))
        rules.insert(0, yardstick.rule)
    return Claim(
        id=id,
        of=Group[text["group"].upper()] if "group" in text else None,
        readings=found.readings,
        assumed=found.assumed,
        compared=found.compared,
        accepted=tuple(words.pop("accepted")),
        tolerance="; ".join(rules),
        seeds=words.pop("seeds", seeds),
        told=found.told,
        **words,
    )
