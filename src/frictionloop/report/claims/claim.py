"""A claim of the paper as data: what is printed, the number here, what counts as agreement, and the verdict."""

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

from frictionloop.report.control_law_study import ORACLE
from frictionloop.report.number_text import number, shown, with_unit
from frictionloop.report.paper_protocol import IDEAL, PRINTED, SLOW, WITH_KP
from frictionloop.report.system_comparison import FEASIBLE
from frictionloop.report.tolerances import YARDSTICKS

T = TypeVar("T")
Value = float | None
"""A computed number; None where what was looked for does not exist."""
Condition = tuple[str, str]
"""A name of numbers, or a part of names, and in words what then holds."""


class Verdict(StrEnum):
    """What the numbers say of a claim or a statement; these are its words everywhere."""

    YES = "yes"
    """Every reading of the text, and whatever it leaves open, gives an accepted number."""
    YES_IF = "yes, if"
    """One named condition, which the text leaves open, gives one."""
    NO = "no"
    NOT_COUNTED = "not counted"

    @property
    def sign(self) -> str:
        """A sign, so that it does not rest on colour."""
        return "✓◐✗·"[list(Verdict).index(self)]

    def under(self, condition: Condition | None) -> str:
        """Return the verdict with what it takes."""
        return f"{self} {condition[1]}" if self is Verdict.YES_IF and condition else str(self)


COUNTED = (Verdict.YES, Verdict.YES_IF, Verdict.NO)


class Group(StrEnum):
    """Why a claim is not counted, in the order of the page."""

    CONSTRUCTION = "decided by construction"
    ARITHMETIC = "arithmetic of the text"
    SLIP = "slips of the text"
    QUESTION = "questions of our own"


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
    group: Group | None = None
    """Why it is not counted."""
    condition: Condition | None = None
    """What it takes; without one the verdict is yes or no."""
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
    """The number for what the text leaves open, such as a reachable set-point: a condition may name it."""
    compared: Mapping[str, Value] = field(default_factory=dict)
    """The number of what is shown beside them and has no vote, such as what the text contradicts."""
    meant: str = ""
    """Of a slip: what must have been meant."""
    digits: int = 3
    """Digits of the numbers where they are shown."""
    seeds: str = ""
    """Of the runs that its numbers come from."""
    told: Mapping[str, Told | str] = field(default_factory=dict)
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
    def in_texts(self) -> dict[str, Told | str]:
        """Numbers as texts name them."""
        return {name: _told(value) for name, value in {**self.all_values, **self.told}.items()}

    def under(self, part: str) -> dict[str, Value]:
        """Return the number of this name, or all with this part in their names, that have a vote."""
        votes = {**self.readings, **self.assumed}
        return {part: votes[part]} if part in votes else having(votes, [part])

    def holds_under(self, part: str) -> bool:
        """Return whether there are such numbers, all accepted."""
        return bool(self.under(part)) and all(self.holds[name] for name in self.under(part))

    @property
    def verdict(self) -> Verdict:
        """What is told of the claim."""
        if self.group is not None:
            return Verdict.NOT_COUNTED
        if self.condition is not None:
            return Verdict.YES_IF if self.holds_under(self.condition[0]) else Verdict.NO
        return Verdict.YES if all(self.holds[name] for name in (*self.readings, *self.assumed)) else Verdict.NO

    @property
    def verdict_text(self) -> str:
        """The verdict with its condition."""
        return self.verdict.under(self.condition)

    @property
    def accepts(self) -> str:
        """The numbers accepted, in words."""
        low, high = self.accepted
        low_text, high_text = (
            with_unit(end, self.unit, self.digits) if math.isfinite(end) else "" for end in (low, high)
        )
        if low == high:
            return low_text
        if math.isinf(high):
            return f"at least {low_text}"
        if math.isinf(low) or low == 0.0:
            return f"at most {high_text}"
        return f"{shown(low, self.digits)} to {high_text}"

    @property
    def rule(self) -> str:
        """The yardstick in a few words."""
        return self.tolerance.partition("; ")[0].replace(" (assumed)", "")

    @property
    def more_rules(self) -> str:
        """What else ``accepted`` comes from."""
        return self.tolerance.partition("; ")[2]

    @property
    def paper_and_ours(self) -> tuple[str, str]:
        """What is printed and the number here, with units; that under the condition too, where it is another."""
        here = with_unit(self.ours, self.unit, self.digits)
        if self.verdict is Verdict.YES_IF and self.condition:
            value = next(iter(self.under(self.condition[0]).values()))
            if (there := with_unit(value, self.unit, self.digits)) != here:
                here = f"{here}; {there} if {self.condition[1]}"
        return with_unit(self.published, self.unit, self.digits), here

    def to_dict(self) -> dict[str, Any]:
        """Return the claim for JSON: an end of ``accepted`` that is infinite becomes null."""
        words = ("id", "title", "place", "quote", "published", "ours", "unit", "measure", "quantity")
        ends = [end if math.isfinite(end) else None for end in self.accepted]
        more = ("group", "meant", "note", "explanation", "seeds", "command")
        return {
            **{name: getattr(self, name) for name in words},
            **{name: dict(getattr(self, name)) for name in ("readings", "assumed", "compared")},
            "tolerance": {"accepted": ends, "from": self.tolerance},
            "verdict": self.verdict_text,
            **{name: getattr(self, name) for name in more},
        }


def having(values: Mapping[str, T], names: Collection[str]) -> dict[str, T]:
    """Return the entries of which a part of the name, between commas, is one of ``names``, which may have commas."""
    return {name: value for name, value in values.items() if any(f", {each}, " in f", {name}, " for each in names)}


def lacking(values: Mapping[str, T], names: Collection[str]) -> dict[str, T]:
    """Return the other entries."""
    kept = having(values, names)
    return {name: value for name, value in values.items() if name not in kept}


OPEN_TO_ASSUME = (FEASIBLE, SLOW, WITH_KP)
"""What the text leaves open: numbers with one of these in their name vote as assumptions."""
WITHOUT_VOTE = (PRINTED, IDEAL, ORACLE)
"""On the bench: gains that ring there, a device without what the text says of it, a law that nobody can build."""
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


Numbers = Mapping[str, Any]
"""What is computed for a claim: readings, assumed, compared and told of `Claim`."""


def numbers(
    values: Mapping[str, Value],
    *,
    compared: Collection[str] = WITHOUT_VOTE,
    assumed: Collection[str] = OPEN_TO_ASSUME,
    **told: float | str | None,
) -> Numbers:
    """Return the numbers of a claim, sorted by what is in their names: readings, assumptions, mere comparisons.

    ``compared`` and ``assumed`` are the parts of names that sort them; ``told`` is for its texts, which may name the
    values too: ``{reachable set-point}``.
    """
    voting = lacking(values, compared)
    return {
        "readings": lacking(voting, assumed),
        "assumed": having(voting, assumed),
        "compared": having(values, compared),
        "told": {name: _told(each) for name, each in told.items()},
    }


def _told(value: float | str | None) -> Told | str:
    return value if isinstance(value, str) else Told(math.nan if value is None else value)


@cache
def texts(topic: str) -> Mapping[str, Any]:
    """Return the texts of a topic's claims, by their ids, in order."""
    found: dict[str, Any] = tomllib.loads(
        (files("frictionloop.report.claims") / f"{topic}.toml").read_text(encoding="utf-8")
    )
    return found


def judged(id: str, text: Mapping[str, Any], found: Numbers, seeds: str) -> Claim:
    """Return the claim of a text and the numbers computed for it."""
    words = {name: value for name, value in text.items() if name not in ("group", "condition", "yardstick", "against")}
    given = {name: _told(each) for kind in found.values() for name, each in kind.items()}
    words |= {name: words[name].format_map(given) for name in FILLED if name in words}
    rules = [words.pop("tolerance")] if "tolerance" in words else []
    if "yardstick" in text:
        yardstick = YARDSTICKS[text["yardstick"]]
        words["accepted"] = yardstick.accepted(text.get("against", text["published"]))
        rules.insert(0, yardstick.rule)
    return Claim(
        id=id,
        group=Group[text["group"].upper()] if "group" in text else None,
        condition=tuple(text["condition"]) if "condition" in text else None,
        accepted=tuple(words.pop("accepted")),
        tolerance="; ".join(rules),
        seeds=words.pop("seeds", seeds),
        **found,
        **words,
    )
