"""Numbers in cells of text: decimal points and commas, thousands, and cells that can be read in two ways."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Literal

import numpy as np

from frictionloop.quantities import must_be
from frictionloop.recordings.dates import is_stamp

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


def is_number(cell: str, decimal: Decimal) -> bool:
    """Return whether a cell holds a number."""
    return _NUMBER[decimal].fullmatch(cell.strip().lstrip("'").translate(_SAME)) is not None


def is_value(cell: str, decimal: Decimal) -> bool:
    """Return whether a cell holds a number, or a time of the clock on the wall."""
    return is_number(cell, decimal) or is_stamp(cell)


def is_absent(cell: str) -> bool:
    """Return whether a cell is what recorders write where there is no number."""
    return _ABSENT.fullmatch(cell.strip()) is not None


def number_in(cell: str, decimal: Decimal) -> float:
    """Return the number in a cell, NaN where there is none."""
    text = cell.strip().lstrip("'").translate(_SAME)
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
