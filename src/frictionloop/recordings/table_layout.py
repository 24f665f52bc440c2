"""How a text file is written: encoding, marks, names, what the lines above its numbers say, where these begin."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictionloop.quantities import must_be
from frictionloop.recordings.contents import told_rate
from frictionloop.recordings.text_numbers import (
    Decimal,
    decimal_in,
    header,
    is_absent,
    is_stamp,
    is_value,
    said_unit,
    stamp_of,
    told_date,
)

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


LOOKED_AT = 200
"""Lines in which names must end and numbers begin (assumed)."""
MOST_COLUMNS = 10_000
"""More than any recorder writes (assumed)."""


class Row(NamedTuple):
    """The cells of a line."""

    line: int
    """Counted from 0."""
    cells: list[str]

    @property
    def width(self) -> int:
        """Cells up to the last that is filled."""
        return max((k + 1 for k, cell in enumerate(self.cells) if cell.strip()), default=0)


class Layout(NamedTuple):
    """How a text file is written."""

    encoding: str
    mark: str
    decimal: Decimal
    taken: bool
    """Whether the decimal mark is a comma that nobody gave."""
    first: int
    """Line at which the numbers begin, counted from 0."""
    names: tuple[str, ...]
    """Of the columns, with their units in brackets; numbers where there are none."""
    named: int
    """Columns that have a name in the file."""
    said: tuple[Said, ...]
    """Settings above the numbers."""
    begun: tuple[tuple[int, np.datetime64], ...] = ()
    """Columns of times of the clock on the wall, and the first of each: they are read in s after it."""

    @property
    def width(self) -> int:
        """Columns."""
        return len(self.names)


def layout_of(path: Path, decimal: Decimal | None = None) -> Layout:
    """Return how a file is written, by its first lines; refuses one without a row of numbers there."""
    encoding = _encoding(path)
    with open(path, encoding=encoding, errors="replace", newline=None) as stream:
        lines = [line.rstrip("\n\0") for line in islice(stream, LOOKED_AT)]
    filled = [line for line in lines if is_row(line)]
    if not filled:
        raise must_be(f"{path}: rows of numbers", 0, "1 or more")
    mark = _mark(filled[-LOOKED_AT // 2 :], decimal)
    said = said_in(lines)
    settings = {each.line - 1 for each in said if tells(each)}
    rows = [Row(k, cells_of(line, mark)) for k, line in enumerate(lines) if is_row(line) and k not in settings]
    if (most := max((len(row.cells) for row in rows), default=0)) > MOST_COLUMNS:
        raise must_be(f"{path}: columns", most, f"at most {MOST_COLUMNS}")
    mark_found = decimal or decimal_in(str(path), _all_rows(path, encoding, mark, rows), mark)
    comments = [Row(k, cells_of(line.lstrip("# "), mark)) for k, line in enumerate(lines) if line.startswith("#")]
    table = _Table(rows, comments, lambda cell: is_value(cell, mark_found))
    first, names, named = table.head(str(path), mark)
    above = tuple(each for each in said if each.line <= first.line)
    begun = tuple((k, stamp_of(cell)) for k, cell in enumerate(first.cells[: len(names)]) if is_stamp(cell))
    taken = decimal is None and mark_found == ","
    return Layout(encoding, mark, mark_found, taken, first.line, names, named, above, begun)


def _all_rows(path: Path, encoding: str, mark: str, rows: Sequence[Row]) -> Iterator[list[str]]:
    """Yield the cells of the first rows, and where these have marks that may be either those of many others."""
    yield from (row.cells for row in rows)
    if any(re.search(r"\d[.,]\d{3}\b", cell) for row in rows for cell in row.cells):
        with open(path, encoding=encoding, errors="replace", newline=None) as stream:
            yield from (cells_of(line, mark) for line in islice(stream, LOOKED_AT, 100 * LOOKED_AT))


def _encoding(path: Path) -> str:
    with open(path, "rb") as stream:
        start = stream.read(4096)
    if start[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    if start[1:200:2].count(0) > len(start[:200]) // 3:
        return "utf-16-le"
    try:
        start.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return "cp1252" if error.start < len(start) - 4 else "utf-8-sig"
    return "utf-8-sig"


def _mark(lines: Sequence[str], decimal: Decimal | None) -> str:
    """Return what parts the cells of lines: 1,5;2,5 and 1,5 2,5 have decimal commas, 1,5 alone is two columns."""
    line = lines[-1].strip()
    if mark := next((each for each in "\t;" if each in line), ""):
        return mark
    commas = [part for part in line.split() if re.fullmatch(r"[+-]?\d+,\d+([eE][+-]?\d+)?", part.strip('"'))]
    alike = len({each.count(",") for each in lines}) > 1 and len({len(each.split()) for each in lines}) == 1
    spaced = " " in line and (decimal == "," or len(commas) > 1 or alike)
    return "," if "," in line and not spaced and decimal != "," else " " if " " in line else "\t"


def is_row(line: str) -> bool:
    """Return whether a line holds cells: it is no comment, and more than blanks and marks."""
    return bool(line.strip(' \t,;"\r\n\0')) and not line.lstrip().startswith(("#", "sep="))


def cells_of(line: str, mark: str) -> list[str]:
    """Return the cells of a line."""
    if mark == " ":
        return line.split()
    return next(csv.reader([line.rstrip("\r\n").replace("\0", "")], delimiter=mark, skipinitialspace=True), [])


class _Table(NamedTuple):
    """The first lines of a file."""

    rows: list[Row]
    comments: list[Row]
    is_value: Callable[[str], bool]

    def head(self, where: str, mark: str) -> tuple[Row, tuple[str, ...], int]:
        """Return the first row of data, the names of the columns, and how many of these are in the file.

        Data begin below the names, or with the first row that has a number: what stands there instead of one, in
        whatever column, is a gap.
        """
        widths = [row.width for row in self.rows if any(map(self.is_value, row.cells))]
        width = Counter(widths).most_common(1)[0][0] if widths else 0
        late = self.rows[len(self.rows) // 2 :]
        columns = {k for row in late for k, cell in enumerate(row.cells) if self.is_value(cell)}
        whole = next((k for k, row in enumerate(self.rows) if self._is_whole(row, width, columns)), None)
        if whole is None:
            raise must_be(f"{where}: rows of numbers", 0, f"some within {LOOKED_AT} lines")
        texts = [row for row in self.rows[:whole] if self._names(row, width)]
        if not texts and (near := [row for row in self.comments if row.line < self.rows[whole].line]):
            texts = [row for row in near[-1:] if width > 1 and self._names(row, width)]
        if not texts and whole and self._may_be_names(whole, width):
            texts = [self.rows[whole - 1]]
        below = texts[-1].line if texts else -1
        data = [row for row in self.rows[: whole + 1] if row.line > below and self._is_data(row, width)]
        first = (data or [self.rows[whole]])[0]
        _refuse_doubtful(where, mark, first, self.rows, [] if not texts else texts[-1].cells)
        widest = max(width, *(row.width for row in texts[-1:]), 0)
        count, names = _named([row.cells for row in texts], widest)
        return first, names, count

    def _is_whole(self, row: Row, width: int, columns: set[int]) -> bool:
        """Return whether a row has a number in each of these columns that is filled."""
        filled = [self.is_value(cell) for k, cell in enumerate(row.cells) if cell.strip() and k in columns]
        return bool(filled) and all(filled) and _is_wide(row, width)

    def _is_data(self, row: Row, width: int) -> bool:
        """Return whether a row has numbers, or what may stand for them."""
        words = any(any(map(str.isalpha, cell)) for cell in row.cells)
        none = _is_wide(row, width) and (not words or self._stands_for_none(row))
        return none or any(map(self.is_value, row.cells))

    def _stands_for_none(self, row: Row) -> bool:
        """Return whether a row holds what stands where there is no number: known words, or the same again."""
        again = sum(row.cells == other.cells for other in self.rows) > 1
        return again or all(is_absent(cell) for cell in row.cells)

    def _names(self, row: Row, width: int) -> bool:
        """Return whether a row may hold names or units: words, and no numbers."""
        words = any(any(map(str.isalpha, cell)) for cell in row.cells)
        none = not any(map(self.is_value, row.cells)) and not self._stands_for_none(row)
        return words and none and _is_wide(row, width) and (width == 1 or row.width > 1)

    def _may_be_names(self, whole: int, width: int) -> bool:
        """Return whether the row above the numbers holds names some of which are numbers: t, 1, 2."""
        row = self.rows[whole - 1]
        words = [cell for cell in row.cells if cell.strip() and not self.is_value(cell)]
        alike = whole > 1 and [each in self.rows[whole - 2].cells for each in words]
        return row.width == width and bool(words) and not alike and not any(map(is_absent, words))


def _is_wide(row: Row, width: int) -> bool:
    return abs(row.width - width) <= max(1, width // 2)


def _named(texts: list[list[str]], count: int) -> tuple[int, tuple[str, ...]]:
    """Return how many columns have a name, and one for each: of the last rows of text, with units and groups."""
    rows = [[cell.strip().strip('"') for cell in row] for row in texts]
    units: list[str] = []
    if len(rows) > 1 and are_units(rows[-1]):
        units = [cell.strip("[]() -") for cell in rows.pop()]
    names = [cell.lstrip("# ") for cell in rows[-1]] if rows else []
    if len(rows) > 1 and len(rows[-2]) == len(names) and ("" in rows[-2] or len(set(names)) < len(names)):
        names = _under_groups([cell.lstrip("# ") for cell in rows[-2]], names)
    if names and names[0] == "" and len(names) == count + 1:
        names = names[1:]
    names, units = ((each + [""] * count)[:count] for each in (names, units))
    shown = [
        f"{name or k} [{unit}]" if unit else name or str(k)
        for k, (name, unit) in enumerate(zip(names, units, strict=True))
    ]
    named = max((k + 1 for k, name in enumerate(names) if name), default=count)
    return named, tuple(shown)


def are_units(row: Sequence[str]) -> bool:
    """Return whether a line is one of units: one that is known, or all in brackets."""
    filled = [cell.strip() for cell in row if cell.strip("[]() -")]
    return any(said_unit(cell.strip("[]() ")) for cell in filled) or (
        bool(filled) and all(cell.startswith(("[", "(")) for cell in filled)
    )


def _under_groups(groups: list[str], names: list[str]) -> list[str]:
    """Return "group name" where names stand under groups; below a blank cell the group before goes on."""
    joined, group = [], ""
    for above, name in zip(groups, names, strict=True):
        group = above or group
        joined.append(f"{group} {name}".strip() if group != name else name)
    return joined


def _refuse_doubtful(where: str, mark: str, first: Row, rows: list[Row], names: list[str]) -> None:
    """Refuse cells that may be the halves of numbers with decimal commas, and a row 0, 1, 2 ... that may be names."""
    data = [[cell.strip() for cell in row.cells] for row in rows if row.line >= first.line]
    said = f"{where}: line {first.line + 1}"
    halves = mark == "," and all(re.fullmatch(r"[+-]?\d+", cell) for cell in data[0] if cell)
    if halves and names and first.width == 2 * len(names):
        raise must_be(said, ",".join(data[0]), f"{len(names)} cells; decimal commas? part columns by semicolons")
    if not names and halves and all(len(row) == 2 and all(map(str.isdecimal, row)) for row in data):
        padded = any(len(row[1]) > 1 and row[1].startswith("0") for row in data)
        if padded or (len(data) > 2 and len({row[0] for row in data}) == 1):
            raise must_be(said, ",".join(data[0]), "one number, by decimal = ',', or two below names")
    numbered = not names and data[0] == [str(k) for k in range(len(data[0]))] and len(data[0]) > 1
    if numbered and len(data) > 1 and all("." in cell or "," in cell for cell in data[1]):
        raise must_be(said, ", ".join(data[0]), "names, or a sample 0.0")
