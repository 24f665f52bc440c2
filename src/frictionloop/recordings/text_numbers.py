"""Cells of text: headers with units, numbers with decimal marks, times and dates, what can be read in two ways."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from datetime import datetime
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities import must_be
from frictionloop.quantities.units import UNITS, known_unit

_IN_BRACKETS = re.compile(r"(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]\s*")
_AFTER_A_MARK = re.compile(r"(.+?)(?:\s*[/,]\s*|\s+(?:in\s+)?)(\S+)")
_AS_SUFFIX = re.compile(r"(.+)_(n|mn|un|kn|v|mv|uv|kgf|gf|kg|g|s|ms|us|[µμ]s|mm)", re.IGNORECASE)
_TIMES = ("time", "t", "timestamp", "zeit", "temps")


OTHERS = {each.lower(): each for each in ("Hz", "kHz", "MHz", "dB", "%", "deg", "°", "rad", "Pa", "kPa", "bar", "rpm")}
"""Units of other things than forces and times: told apart from the name, and never scaled."""


class Header(NamedTuple):
    """A column's name without its unit, and the unit: one that is known, or what stands in its place."""

    name: str
    unit: str | None


def header(text: str) -> Header:
    """Return what a header says: "Ft [mN]", "Ft (mN)", "Ft/mN", "Ft in mN" and "ft_mn" are all in mN."""
    text = text.strip()
    if match := _IN_BRACKETS.fullmatch(text):
        return Header(match[1].strip(), said_unit(match[2]) or match[2] or None)
    if (match := _AFTER_A_MARK.fullmatch(text)) and said_unit(match[2]):
        return Header(match[1].strip(), said_unit(match[2]))
    if match := _AS_SUFFIX.fullmatch(text):
        lower = {unit.lower(): unit for unit in UNITS}
        return Header(match[1], lower.get(match[2].lower(), "us"))
    return Header(text, None)


def said_unit(text: str) -> str | None:
    """Return how this package spells a unit, also one that it cannot scale; None for what is none."""
    return known_unit(text) or OTHERS.get(text.strip().lower())


def is_time(text: str) -> bool:
    """Return whether a header is that of a column of times."""
    name, unit = header(text)
    return name.lower() in _TIMES and (unit not in UNITS or UNITS[unit][0] == "s")


def plain_text(value: Any) -> str:
    """Return a single value as text, whether it is one, bytes or a number; "" of none or of several."""
    one = np.ravel(value)[0] if np.size(value) == 1 else ""
    return one.decode("utf-8", "replace") if isinstance(one, bytes) else str(one)


ACCEPTED = "a number, or a time as 2024-03-05T10:11:12.345"
"""Forms of a cell of times; the date may be left out, of less than a day."""
_TIME = r"(\d?\d:\d\d(?::\d\d(?:[.,]\d{1,9})?)?)"
_STAMP = re.compile(rf"(?:(\d{{4}}-\d\d-\d\d)[T ])?{_TIME}\s*(?:Z|([+-]\d\d):?(\d\d)?)?")
_NOT = np.datetime64("NaT", "ns")
_DAY, _UNDATED = np.timedelta64(1, "D"), "1970-01-01"


def stamp_of(cell: str) -> np.datetime64:
    """Return the time that a cell holds, in UTC where it says a zone; NaT if it holds none."""
    found = _STAMP.fullmatch(cell.strip())
    if found is None or (found[1] is None and found[2].count(":") < 2):
        return _NOT
    date, local, hours, minutes = found.groups()
    try:
        time = np.datetime64(f"{date or _UNDATED}T{'0' * (local[1] == ':')}{local.replace(',', '.')}", "ns")
    except ValueError:  # a month 13
        return _NOT
    east = 0 if hours is None else 60 * int(hours) + int(f"{hours[0]}{minutes or 0}")
    return time + np.timedelta64(-east, "m")


def is_stamp(cell: str) -> bool:
    """Return whether a cell holds such a time."""
    return not np.isnat(stamp_of(cell))


def seconds_after(start: np.datetime64, cells: Iterable[str]) -> NDArray[np.float64]:
    """Return the times in cells in s after one of them, NaN where there is none; to a ns over some months."""
    after = np.array([stamp_of(each) for each in cells], dtype="datetime64[ns]") - start
    return np.asarray((after if shown(start) else after % _DAY) / np.timedelta64(1, "s"), dtype=float)


def shown(time: np.datetime64) -> str:
    """Return a time in whole seconds, "" of one without a date."""
    text = str(np.datetime_as_string(time, unit="s"))
    return "" if text.startswith(_UNDATED) else text


_DATES = {"date", "wfstarttime", "datetime", "recorded", "starttime"}
_FORMS: tuple[str, ...] = ("%Y/%m/%d %H:%M:%S", "%Y/%m/%d", "%a %b %d %H:%M:%S %Y", "%d.%m.%Y %H:%M:%S", "%d.%m.%Y")
_FORMS += ("%d-%b-%y %H:%M:%S", "%d-%b-%Y %H:%M:%S", "%d-%b-%y", "%d-%b-%Y", "%Y%m%d")
"""Dates that can be read in one way alone."""


def iso_date(text: str) -> str:
    """Return a date, with its time where that stands there, to the second; "" of what is none, or may be two.

    >>> iso_date("2024/03/05 10:00:00,5"), iso_date("Tue Mar  5 10:11:12 2024"), iso_date("3/5/2024")
    ('2024-03-05T10:00:00', '2024-03-05T10:11:12', '')
    """
    text = re.sub(r"(:\d\d)[.,]\d+", r"\1", " ".join(text.split()))
    for form in ("", *_FORMS):
        with suppress(ValueError):
            found = datetime.strptime(text, form) if form else datetime.fromisoformat(text)
            return found.date().isoformat() if ":" not in text and "T" not in text else found.isoformat()
    return ""


def told_date(pairs: Iterable[tuple[str, Any]]) -> str:
    """Return the first date that names and values tell, "" without one."""
    for name, value in pairs:
        if re.sub(r"[^a-z]", "", name.rpartition("/")[2].lower()) in _DATES and (date := iso_date(plain_text(value))):
            return date
    return ""


Decimal = Literal[".", ","]
OTHER: dict[str, Decimal] = {".": ",", ",": "."}
_SPACES = "'\u2019\u00a0\u202f\u2009"
"""What parts thousands besides the other mark."""
_SAME = str.maketrans({"\u2212": "-", "D": "e", "d": "e"})
_MARKED = re.compile(rf"[+-]?[\d.,{_SPACES}]*\d[\d.,]*([eEdD][+-]?\d+)?")
_ABSENT = re.compile(
    r"[-+*#.?_<>\s]*|[<>]\s*[+-]?[\d.,]+|#?n/?[av]|nan|null|none|missing|over\w*|under\w*|ovl?d?|ol|err(or)?|sat\w*",
    re.IGNORECASE,
)
"""What recorders write where there is no number."""


def _pattern(decimal: Decimal) -> re.Pattern[str]:
    mark, group = re.escape(decimal), f"[{re.escape(OTHER[decimal])}{_SPACES}]"
    whole = rf"(?:[1-9]\d{{0,2}}(?:{group}\d{{3}})+|\d+)"
    return re.compile(rf"[+-]?(?:{whole}(?:{mark}\d*)?|{mark}\d+)(?:[eEdD][+-]?\d+)?|[+-]?(?:nan|inf)", re.IGNORECASE)


_NUMBER = {".": _pattern("."), ",": _pattern(",")}
_GROUPS = {decimal: re.compile(rf"[{re.escape(OTHER[decimal])}{_SPACES}]") for decimal in OTHER}
_EITHER = re.compile(r"[+-]?[1-9]\d{0,2}[.,]\d{3}")


def _bare(cell: str) -> str:
    return cell.strip().lstrip("'").translate(_SAME)


def is_value(cell: str, decimal: Decimal) -> bool:
    """Return whether a cell holds a number, or a time of the clock on the wall."""
    return _NUMBER[decimal].fullmatch(_bare(cell)) is not None or is_stamp(cell)


def is_absent(cell: str) -> bool:
    """Return whether a cell is what recorders write where there is no number."""
    return _ABSENT.fullmatch(cell.strip()) is not None


def number_in(cell: str, decimal: Decimal) -> float:
    """Return the number in a cell, NaN where there is none."""
    text = _bare(cell)
    if _NUMBER[decimal].fullmatch(text) is None:
        return np.nan
    return float(_GROUPS[decimal].sub("", text).replace(decimal, "."))


def decimal_in(where: str, rows: Iterable[list[str]], mark: str) -> Decimal:
    """Return the decimal mark of a file, from the cells of its rows, which another mark parts.

    A mark with other than three digits behind it, or a 0 before it, is decimal; the last of two kinds in a cell is; one
    that stands twice parts thousands. Commas that may be either are refused, with both readings, and so are points in a
    column that has whole numbers too.

    Raises
    ------
    FrictionloopError
        For numbers that can be read in two ways.
    """
    tells, either, whole = set[str](), {".": dict[int, str](), ",": dict[int, str]()}, set[int]()
    for k, cell in ((k, cell.strip()) for row in rows for k, cell in enumerate(row)):
        marks = [each for each in cell if each in OTHER] if _MARKED.fullmatch(cell) else []
        if _EITHER.fullmatch(cell):
            either[marks[0]].setdefault(k, cell)
        elif marks:
            decimal = marks[-1] if marks.count(marks[-1]) == 1 else OTHER[marks[-1]]
            tells.update(decimal * (_NUMBER[decimal].fullmatch(cell) is not None))
        elif cell.isdecimal():
            whole.add(k)
    if "," in tells and "." not in tells:
        return ","
    points = {} if mark == "," else {k: cell for k, cell in either["."].items() if k in whole}
    text = next(iter((either[","] or points).values()), "")
    if tells or not text:
        return "."
    one, other = number_in(text, ","), number_in(text, ".")
    raise must_be(f"{where}: {text!r}", f"{one:g} or {other:g}", "told by decimal = ',' or '.'")
