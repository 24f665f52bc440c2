"""Columns of text files: CSV, TSV and TXT, with every refusal naming the line."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import dropwhile, islice

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.recordings.column import Column, column_number
from frictionloop.recordings.contents import one_rate
from frictionloop.recordings.headers import header, is_time
from frictionloop.recordings.preamble import Said, rates_in, tells, unit_in, unit_in_doubt
from frictionloop.recordings.stamps import is_stamp, seconds_after, stamp_of
from frictionloop.recordings.text_rows import (
    LOOKED_AT,
    Row,
    comments_of,
    few_names,
    head_of,
    mark_of,
    readable,
    rows_of,
    settings_of,
)

_COMMA = "; a decimal comma? --disturbance.decimal ,"
_COMMAS = "; decimal commas? separate columns by semicolons"
_POINT = "; a decimal point? --disturbance.decimal ."


@dataclass(frozen=True)
class _Table:
    """A text file: the names of its columns (none without a header), how many there are, and what parts them."""

    path: str
    decimal: str
    names: list[str]
    first: Row
    """The first row of data."""
    count: int
    mark: str
    head: str
    """Where its names and units stand, in words."""

    def header_lines(self) -> list[Said]:
        """Return what the lines above the numbers tell."""
        return settings_of(self.path, self.first[0] - 1)

    def rows(self) -> Iterator[Row]:
        """Yield the rows of data."""
        return dropwhile(lambda row: row[0] < self.first[0], rows_of(self.path, self.decimal, self.mark))

    def column(self, k: int, times: Column | None = None, others: list[str] | None = None) -> Column:
        """Return column k."""
        values = np.fromiter((self.number(cells, k) for _, cells in self.rows()), np.float64)
        name = self.name(k)
        place = partial(self.place, k=k)
        return Column(values, place, name, header(name).unit, times=times, others=others or [], head=self.head)

    def name(self, k: int) -> str:
        """Return what column k is called, "" without a name."""
        return self.names[k] if k < len(self.names) else ""

    def times(self, k: int) -> Column:
        """Return column k, of times of the clock on the wall in s after the first."""
        found = self.column(k)
        if np.isfinite(found.samples).any():
            return found
        cells = [cells[k] if k < len(cells) else "" for _, cells in self.rows()]
        start = next((each for each in map(stamp_of, cells) if not np.isnat(each)), None)
        return found if start is None else replace(found, samples=seconds_after(start, cells), unit="s")

    def number(self, cells: list[str], k: int) -> float:
        """Return what stands in column k of a row, NaN if that is no number."""
        return np.nan if self.too_long(cells) or k >= len(cells) else _number(cells[k], self.decimal)

    def too_long(self, cells: list[str]) -> bool:
        """Return whether a row has more cells than there are columns, as a decimal comma makes them."""
        return any(cell.strip() for cell in cells[self.count :])

    def place(self, i: int, k: int) -> str:
        """Return where row i of column k stands, and what is there."""
        line, cells = next(islice(self.rows(), i, None))
        name = self.name(k) or f"column {k}"
        if self.too_long(cells):
            halves = self.mark == "," and not any("." in cell for cell in cells)
            hint = "" if not halves else _COMMAS if self.count > 1 else _COMMA
            return f"line {line}: {name} is in a row of {len(cells)} cells, of {self.count} columns{hint}"
        cell = cells[k].strip() if k < len(cells) else ""
        other, hint = (",", _COMMA) if self.decimal == "." else (".", _POINT)
        return f"line {line}: {name} is {f'{cell!r:.40}' if cell else 'blank'}{hint if other in cell else ''}"


def read_text(recording: Recording) -> Column:
    """Return a column of a text file, and its column of times if it has one."""
    table = _table(recording.path, recording.decimal)
    k = column_number(recording, table.names, table.count, table.head)
    if not table.names:
        _refuse_halves(table)
    called = [i for i, name in enumerate(table.names) if is_time(name)]
    stamped = [i for i, cell in enumerate(table.first[1]) if is_stamp(cell)]
    clock = next((i for i in called + stamped if i != k), None)
    others = [repr(table.name(i) or str(i)) for i in range(table.count) if i not in (k, clock)]
    column = table.column(k, None if clock is None else table.times(clock), others)
    said, signals = table.header_lines(), 1 + len(others)
    by, rate_hz = one_rate(recording.path, rates_in(said)) or ("", None)
    unit = column.unit or unit_in(said, column.name, signals)
    doubt = "" if unit else unit_in_doubt(said, signals)
    return replace(column, unit=unit, unit_in_doubt=doubt, rate_by=by, rate_hz=rate_hz)


def _table(path: str, decimal: str) -> _Table:
    mark = mark_of(path, decimal)
    rows = list(islice(rows_of(path, decimal, mark), LOOKED_AT))
    if not rows:
        raise must_be(f"{path}: rows of numbers", 0, "1 or more")
    settings = {each.line for each in settings_of(path, LOOKED_AT) if tells(each)}
    rows = [row for row in rows if row[0] not in settings]
    if not rows:
        raise must_be(f"{path}: rows of numbers", 0, f"some within {LOOKED_AT} lines")
    first, second = (*rows, (rows[0][0] + 1, []))[:2]
    head = head_of(rows, comments_of(path, mark), partial(_is_value, decimal=decimal))
    if head is not None:
        names = [readable(cell) for cell in head.columns()]
        return _Table(path, decimal, names, head.first, len(head.first[1]), mark, str(head))
    if decimal == ".":
        _refuse_commas(path, rows)
    numbers = [_is_number(cell, decimal) for cell in first[1]]
    below = [_is_number(cell, decimal) for cell in second[1]]
    text_over_number = any(
        under and cell.strip() and not number for cell, number, under in zip(first[1], numbers, below, strict=False)
    )
    if any(numbers) and not text_over_number:
        _refuse_numbered(path, first, second[1])
        return _Table(path, decimal, [], first, len(first[1]), mark, "no line of names")
    names = [readable(cell) for cell in first[1]]
    if not any(below) and len(second[1]) > len(names):
        said = ", ".join(map(readable, second[1]))
        raise must_be(f"{path}: line {second[0]}", said, f"numbers or units below {', '.join(names)}")
    data = next((row for row in rows[1:] if row[1]), second)
    count = len(data[1]) if _are_more(data[1], names, mark, decimal) else len(names)
    few = f" for {few_names(len(names), count)}" if count > len(names) else ""
    return _Table(path, decimal, names, data, count, mark, f"names in line {first[0]}{few}")


def _are_more(cells: list[str], names: list[str], mark: str, decimal: str) -> bool:
    """Return whether a row has more columns than there are names, and not one number in two at a decimal comma."""
    halves = mark == "," and not any("." in cell for cell in cells)
    filled = len(cells) > len(names) > 1 and bool(cells[-1].strip())
    return filled and not halves and all(_is_value(cell, decimal) for cell in cells if cell.strip())


def _refuse_numbered(path: str, first: Row, below: list[str]) -> None:
    """Refuse a first row 0, 1, 2 ... over fractions: some programs write it to name columns."""
    numbered = [cell.strip() for cell in first[1]] == [str(k) for k in range(len(first[1]))]
    if numbered and len(first[1]) > 1 and below and all("." in cell or "," in cell for cell in below):
        raise must_be(f"{path}: line {first[0]}", ", ".join(first[1]), "names, or a sample 0.0")


def _refuse_commas(path: str, rows: list[Row]) -> None:
    """Refuse a file whose numbers are found below titles and names only if its commas are decimal ones."""
    head = head_of(rows, [], partial(_is_number, decimal=","))
    if head is not None and (head.names[0] != rows[0][0] or head.units is not None):
        cell = next((cell for cell in head.first[1] if "," in cell), "")
        raise FrictionloopError(f"{path}: line {head.first[0]}: {cell!r:.40} is no number{_COMMA}")


def _refuse_halves(table: _Table) -> None:
    """Refuse two columns of whole numbers that look like the halves of numbers with a decimal comma."""
    cells = [row for _, row in islice(table.rows(), 100)]
    if table.mark != "," or not all(len(row) == 2 and all(map(str.isdecimal, row)) for row in cells):
        return
    padded = any(len(row[1]) > 1 and row[1].startswith("0") for row in cells)
    if padded or (len(cells) > 2 and len({row[0] for row in cells}) == 1):
        said = f"{table.path}: line {table.first[0]}: {','.join(cells[0])}"
        raise FrictionloopError(f"{said} may be one number{_COMMA}, or below two names")


def _number(cell: str, decimal: str) -> float:
    if "_" in cell or (decimal == "," and "." in cell):
        return np.nan
    try:
        return float(cell.replace(decimal, "."))
    except ValueError:
        return np.nan


def _is_number(cell: str, decimal: str) -> bool:
    return not np.isnan(_number(cell, decimal)) or cell.strip().lower().lstrip("+-") == "nan"


def _is_value(cell: str, decimal: str) -> bool:
    return _is_number(cell, decimal) or is_stamp(cell)
