"""From the text of a claim and its numbers to the claim: who votes, what is accepted, and the words with numbers in."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from frictionloop.report.beyond import ORACLE
from frictionloop.report.claims.claim import Claim, Group, Value, having, lacking
from frictionloop.report.device import IDEAL, PRINTED
from frictionloop.report.numbers import number
from frictionloop.report.results import variants
from frictionloop.report.systems import FEASIBLE
from frictionloop.report.tolerances import YARDSTICKS

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
