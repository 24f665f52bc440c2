"""Columns of text files: CSV, TSV and TXT, with every refusal naming the line."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain, dropwhile, islice

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.scales import UNITS
from frictionloop.recordings.column import Array, Column, column_number, refuse_gaps
from frictionloop.recordings.headers import header, is_time

_EVEN = 1e-3
"""How far a step of time may be off, as a share."""


def read_text(recording: Recording) -> Column:
    """Return a column of a text file and, if it has a column of times, its rate."""
    path, decimal = recording.path, recording.decimal
    names, rows = _table(path, decimal)
    count = len(names or next(rows)[1])
    k = column_number(recording, names, count)

    def values(k: int) -> Array:
        return np.fromiter((_number(cells, k, count, decimal) for _, cells in _table(path, decimal)[1]), np.float64)

    def place(i: int, k: int) -> str:
        line, cells = next(islice(_table(path, decimal)[1], i, None))
        name = names[k] if names else f"column {k}"
        if _too_long(cells, count):
            return f"line {line}: {name} is in a row of {len(cells)} cells, of {count} columns{_COMMA}"
        cell = cells[k].strip() if k < len(cells) else ""
        hint = _COMMA if "," in cell and decimal == "." else ""
        return f"line {line}: {name} is {f'{cell!r:.40}' if cell else 'blank'}{hint}"

    clock = next((i for i, name in enumerate(names) if is_time(name)), None)
    used = values(k)
    if k == clock or (count > 1 and _is_clock(used)):
        others = ", ".join(repr(names[i] if names else str(i)) for i in range(count) if i not in (k, clock))
        raise FrictionloopError(f"{path}: column = {recording.column!r} holds times; accepted: {others or 'a force'}")
    file_hz = None
    if clock is not None:
        second = UNITS[header(names[clock]).unit or "s"][1]
        file_hz = _rate_of(path, second * values(clock), partial(place, k=clock), recording.rate_hz)
    return Column(used, partial(place, k=k), file_hz, header(names[k]).unit if names else None)


_COMMA = '; is that a decimal comma? decimal = "," reads it'


def _is_clock(values: Array) -> bool:
    """Return whether values rise in even steps, as times do and no measured force does."""
    steps = np.diff(values[:1000])
    return steps.size > 1 and bool(steps.min() > 0) and bool(np.ptp(steps) <= 2 * _EVEN * steps.mean())


def _rate_of(path: str, times: Array, place: Callable[[int], str], given_hz: float | None) -> float | None:
    """Return the rate of a column of times in s, None if it is too short to tell, or uneven where a rate is given."""
    if given_hz is not None and not np.all(np.isfinite(times)):
        return None
    refuse_gaps(path, times, place)
    if times.size < 2:
        return None
    steps = np.diff(times)
    usual = float(np.median(steps))
    uneven = np.flatnonzero((np.abs(steps - usual) > _EVEN * abs(usual)) | (steps <= 0))
    if uneven.size and given_hz is not None:
        return None
    if uneven.size:
        raise FrictionloopError(
            f"{path}: {place(uneven[0] + 1)}, {steps[uneven[0]]:g} s after the row before: a gap; "
            f"accepted: even steps (most are {usual:g} s), or rate_hz given"
        )
    return float(f"{(times.size - 1) / (times[-1] - times[0]):.9g}")


def _table(path: str, decimal: str) -> tuple[list[str], Iterator[tuple[int, list[str]]]]:
    """Return the names (none without a header) and the rows of data, each with its line in the file."""
    rows = _rows(path, decimal)
    first = next(rows, None)
    if first is None:
        raise FrictionloopError(f"{path}: is empty; accepted: rows of numbers")
    if any(_is_number(cell, decimal) for cell in first[1]):
        return [], chain([first], rows)
    return [cell.strip() for cell in first[1]], dropwhile(lambda row: not row[1], rows)


def _rows(path: str, decimal: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and the cells of each row; no cells for a blank line with more rows after it."""
    with open(path, encoding="utf-8-sig", errors="replace", newline="") as stream:
        sample = [line.strip() for line in islice(stream, 100) if line.strip() and not _is_comment(line)]
        marks = "\t;, ".replace(decimal, "")
        mark = next((mark for mark in marks if sample and mark in sample[-1]), "\t")
        stream.seek(0)
        tidy = (lambda line: "\t".join(line.split())) if mark == " " else str
        reader = csv.reader(
            ("#" if _is_comment(line) else tidy(line) for line in stream),
            delimiter="\t" if mark == " " else mark,
        )
        blank: list[int] | None = None
        for cells in reader:
            if cells == ["#"]:
                continue
            if any(cell.strip() for cell in cells):
                yield from ((line, []) for line in blank or [])
                blank = []
                yield reader.line_num, cells
            elif blank is not None:
                blank.append(reader.line_num)


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith("#")


def _too_long(cells: list[str], count: int) -> bool:
    """Return whether a row has more cells than there are columns, as a decimal comma makes them."""
    return any(cell.strip() for cell in cells[count:])


def _number(cells: list[str], k: int, count: int, decimal: str) -> float:
    try:
        return np.nan if _too_long(cells, count) else float(cells[k].replace(decimal, "."))
    except (ValueError, IndexError):
        return np.nan


def _is_number(cell: str, decimal: str) -> bool:
    return not np.isnan(_number([cell], 0, 1, decimal)) or cell.strip().lower().lstrip("+-") == "nan"
