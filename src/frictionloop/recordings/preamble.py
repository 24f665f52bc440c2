"""What the lines above the numbers of a text file say besides names: the rate, a unit, the date."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from frictionloop.recordings.contents import told_date, told_rate
from frictionloop.recordings.headers import header, said_unit

_MARKS = re.compile(r"\s*[:=\t;]\s*")
_NUMBER_LAST = re.compile(r"([^\d]*[^\d\s,])[\s,]+([+-]?[\d.].*)")
_UNIT = re.compile(r"(.*?)[ _]*\bunits?", re.IGNORECASE)


class Said(NamedTuple):
    """A name and a value above the numbers, and the line they stand in, from 1."""

    line: int
    name: str
    value: str


def said_in(lines: Iterable[str]) -> list[Said]:
    """Return the names with values among lines: "# rate_hz: 1000", "Sample rate,1 kHz", "unit = mN"."""
    found = []
    for number, line in enumerate(lines, 1):
        text = line.strip().lstrip("#%!; ").strip("\"' \t;,")
        parts = _MARKS.split(text, maxsplit=1)
        if len(parts) < 2 and (match := _NUMBER_LAST.fullmatch(text)):
            parts = [match[1], match[2]]
        if len(parts) < 2:
            parts = text.split(",")
        name, value = (parts[0].strip("\"' "), parts[1].strip("\"' \t;,")) if len(parts) == 2 else ("", "")
        if name and value:
            found.append(Said(number, name, value))
    return found


def tells(said: Said) -> bool:
    """Tell whether a line is one of settings, which holds no names of columns."""
    pair = [(said.name, said.value)]
    return told_rate(*pair[0]) is not None or bool(told_date(pair)) or _is_unit(said)


def rates_in(said: Iterable[Said]) -> dict[str, float]:
    """Return the sampling rates in Hz by what says them."""
    told = {f"{each.name!r} in line {each.line}": told_rate(each.name, each.value) for each in said}
    return {name: rate for name, rate in told.items() if rate is not None}


def unit_in(said: Iterable[Said], column: str, signals: int) -> str | None:
    """Return the unit that is said of a column: "force unit: mN", or "unit: mN" where it is the only signal."""
    for each in filter(_is_unit, said):
        of = _unit_of(each)
        if of == header(column).name.casefold() or (not of and signals == 1):
            return said_unit(each.value)
    return None


def unit_in_doubt(said: Iterable[Said], signals: int) -> str:
    """Return the refusal of a unit that is that of one of several signals, "" without one."""
    for each in filter(_is_unit, said):
        if not _unit_of(each) and signals > 1:
            return (
                f"line {each.line}: {each.name!r} is {each.value}, of one of {signals} columns; accepted: "
                f"unit = {each.value} given"
            )
    return ""


def _unit_of(said: Said) -> str:
    """Return the column that a unit is said of, "" if it is not said."""
    match = _UNIT.fullmatch(said.name)
    return header(match[1]).name.casefold() if match else ""


def _is_unit(said: Said) -> bool:
    return _UNIT.fullmatch(said.name) is not None and said_unit(said.value) is not None


def names_only(head: Sequence[list[str]], lines: Sequence[str]) -> list[list[str]]:
    """Return those rows above the numbers that name columns: below the settings, and no comments above names."""
    settings = {each.line for each in said_in(lines) if tells(each)}
    comments = {number for number, line in enumerate(lines, 1) if line.lstrip().startswith("#")}
    filled = [number for number, line in enumerate(lines, 1) if line.strip() and number not in settings]
    below = [number for number in filled if number > max(settings, default=0)]
    without = settings | (set(filled) - set(below) if below else set())
    if filled and filled[-1] not in comments:
        without |= comments
    return [row for number, row in enumerate(head, 1) if number not in without]
