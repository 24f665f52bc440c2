"""Columns of text files: CSV, TSV and TXT, with every refusal naming the line."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain, dropwhile, islice

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.column import Array, Column, column_number, refuse_gaps

_TIME_NAMES = ("time", "time_s", "t")


def read_text(recording: Recording) -> Column:
    """Return a column of a text file and, if it has a column of seconds, its rate."""
    path = recording.path
    names, rows = _table(path)
    count = len(names or next(rows)[1])
    k = column_number(recording, names, count)

    def values(k: int) -> Array:
        return np.fromiter((_number(cells, k, count) for _, cells in _table(path)[1]), np.float64)

    def place(i: int, k: int) -> str:
        line, cells = next(islice(_table(path)[1], i, None))
        name = names[k] if names else f"column {k}"
        if _too_long(cells, count):
            return f"line {line}: {name} is in a row of {len(cells)} cells, of {count} columns"
        cell = cells[k].strip() if k < len(cells) else ""
        return f"line {line}: {name} is {f'{cell!r:.40}' if cell else 'blank'}"

    clock = next((names.index(name) for name in _TIME_NAMES if name in names), None)
    if k == clock:
        others = ", ".join(repr(name) for name in names if name not in _TIME_NAMES)
        raise FrictionloopError(f"{path}: column = {recording.column!r} holds times; accepted: {others or 'a force'}")
    file_hz = None
    if recording.rate_hz is None and clock is not None:
        file_hz = _rate_of(path, values(clock), partial(place, k=clock))
    return Column(values(k), partial(place, k=k), file_hz)


def _rate_of(path: str, times: Array, place: Callable[[int], str]) -> float | None:
    """Return the rate of a column of times in s, None if it is too short to tell."""
    refuse_gaps(path, times, place)
    if times.size < 2:
        return None
    steps = np.diff(times)
    usual = float(np.median(steps))
    uneven = np.flatnonzero((np.abs(steps - usual) > 1e-3 * abs(usual)) | (steps <= 0))
    if uneven.size:
        raise FrictionloopError(
            f"{path}: {place(uneven[0] + 1)}, {steps[uneven[0]]:g} s after the row before: a gap; "
            f"accepted: even steps (most are {usual:g} s), or rate_hz given"
        )
    return float(f"{(times.size - 1) / (times[-1] - times[0]):.9g}")


def _table(path: str) -> tuple[list[str], Iterator[tuple[int, list[str]]]]:
    """Return the names (none without a header) and the rows of data, each with its line in the file."""
    rows = _rows(path)
    first = next(rows, None)
    if first is None:
        raise FrictionloopError(f"{path}: is empty; accepted: rows of numbers")
    if any(map(_is_number, first[1])):
        return [], chain([first], rows)
    return [cell.strip() for cell in first[1]], dropwhile(lambda row: not row[1], rows)


def _rows(path: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and the cells of each row; no cells for a blank line with more rows after it."""
    with open(path, encoding="utf-8-sig", errors="replace", newline="") as stream:
        sample = [line.strip() for line in islice(stream, 100) if line.strip() and not _is_comment(line)]
        mark = next((mark for mark in "\t;, " if sample and mark in sample[-1]), "\t")
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


def _number(cells: list[str], k: int, count: int) -> float:
    try:
        return np.nan if _too_long(cells, count) else float(cells[k])
    except (ValueError, IndexError):
        return np.nan


def _is_number(cell: str) -> bool:
    return not np.isnan(_number([cell], 0, 1)) or cell.strip().lower().lstrip("+-") == "nan"
