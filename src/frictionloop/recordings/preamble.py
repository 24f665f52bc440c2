"""What the lines above the numbers of a text file say besides names: the rate, a unit, the date."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from frictionloop.recordings.contents import told_rate
from frictionloop.recordings.dates import told_date
from frictionloop.recordings.headers import header, said_unit

_MARKS = re.compile(r"\s*(?:[:=\t;]|(?<!\d),(?=[^,]*$))\s*")
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


def unit_in(said: Iterable[Said], column: str, signals: int) -> tuple[str | None, str]:
    """Return the unit that is said of a column, "force unit: mN", or "unit: mN" where it is the only signal.

    With it why a unit is not taken: it is that of one of several signals.
    """
    doubt = ""
    for each in filter(_is_unit, said):
        match = _UNIT.fullmatch(each.name)
        of = header(match[1]).name.casefold() if match else ""
        if of == header(column).name.casefold() or (not of and signals == 1):
            return said_unit(each.value), ""
        if not of and not doubt:
            doubt = f"line {each.line}: {each.name!r} is {each.value}, of one of {signals} columns; accepted: "
            doubt += f"unit = {each.value} given"
    return None, doubt


def _is_unit(said: Said) -> bool:
    return _UNIT.fullmatch(said.name) is not None and said_unit(said.value) is not None
