"""Rows of a text file, and which lines are its names and units: the last ones above the first row of numbers."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import NamedTuple

from frictionloop.recordings.headers import said_unit
from frictionloop.recordings.preamble import Said, said_in

LOOKED_AT = 200
"""Lines in which names must end and numbers begin (assumed)."""
Row = tuple[int, list[str]]
"""A line's number in the file, and its cells."""


def mark_of(path: str, decimal: str) -> str:
    """Return what parts the columns: a tab, a semicolon, a comma or spaces, by the last of the first lines."""
    with _opened(path) as stream:
        sample = [line.strip() for line in islice(stream, 100) if line.strip() and not _is_comment(line)]
    return next((mark for mark in "\t;, ".replace(decimal, "") if sample and mark in sample[-1]), "\t")


def rows_of(path: str, decimal: str, mark: str) -> Iterator[Row]:
    """Yield the line number and the cells of each row; no cells for a blank line with more rows after it."""
    with _opened(path) as stream:
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


def settings_of(path: str, lines: int) -> list[Said]:
    """Return what the first lines tell besides names."""
    with _opened(path) as stream:
        return said_in(map(readable, islice(stream, lines)))


def comments_of(path: str, mark: str) -> list[Row]:
    """Return the comments among the first lines as cells."""
    with _opened(path) as stream:
        lines = [(number, line.strip()) for number, line in enumerate(islice(stream, LOOKED_AT), 1)]
    said = [(number, line.lstrip("# ")) for number, line in lines if line.startswith("#")]
    return [
        (number, line.split() if mark == " " else next(csv.reader([line], delimiter=mark), [])) for number, line in said
    ]


def _opened(path: str):  # type: ignore[no-untyped-def]
    with open(path, "rb") as stream:
        wide = stream.read(2) in (b"\xff\xfe", b"\xfe\xff")
    if wide:
        return open(path, encoding="utf-16", errors="replace", newline="")
    return open(path, encoding="utf-8-sig", errors="surrogateescape", newline="")


def readable(cell: str) -> str:
    """Return a cell with bytes that are no UTF-8 as older programs of Windows write them."""
    cell = cell.strip()
    try:
        cell.encode()
    except UnicodeEncodeError:
        return cell.encode("utf-8", "surrogateescape").decode("cp1252", "replace")
    return cell


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(("#", "sep="))


class Head(NamedTuple):
    """Names and units of columns, where they stand, and the first row of numbers below."""

    names: Row
    units: Row | None
    first: Row

    def columns(self) -> list[str]:
        """Return each column's name with its unit in brackets."""
        names, units = self.names[1], [] if self.units is None else [_bare(cell) for cell in self.units[1]]
        units += [""] * (len(names) - len(units))
        return [f"{name} [{unit}]" if unit.strip("-") else name for name, unit in zip(names, units, strict=False)]

    def __str__(self) -> str:
        """Return where names and units stand, in words."""
        return f"names in line {self.names[0]}" + (f", units in line {self.units[0]}" if self.units else "")


def head_of(rows: Sequence[Row], comments: Sequence[Row], is_number: Callable[[str], bool]) -> Head | None:
    """Return the head of a file, None if its first row is numbers or nothing above has as many cells.

    Names are the last line above the numbers with a cell for each column, of units the line below that one. What stands
    above them, titles and settings, is passed over. A comment of as many cells right above the numbers is a line of
    names too.
    """
    numbers = [
        k for k, (_, cells) in enumerate(rows) if cells and all(is_number(each) for each in cells if each.strip())
    ]
    if not numbers:
        return None
    first = rows[numbers[0]]
    width = len(first[1])
    wide = [row for row in rows[: numbers[0]] if _is_text(row[1], width, is_number)]
    units = wide.pop() if len(wide) > 1 and are_units(wide[-1][1]) else None
    if wide:
        return Head(wide[-1], units, first)
    near = [row for row in comments if row[0] < first[0]]
    if not numbers[0] and near and width > 1 and _is_text(near[-1][1], width, is_number):
        return Head(near[-1], None, first)
    return None


def few_names(named: int, count: int) -> str:
    """Return in words that a header has names for the first columns only."""
    return f"{named} of {count} columns, from the left; the others go by number"


def are_units(cells: Sequence[str]) -> bool:
    """Return whether a line is one of units: one that is known, or all in brackets."""
    filled = [cell.strip() for cell in cells if _bare(cell).strip("-")]
    return any(said_unit(_bare(cell)) for cell in filled) or (
        bool(filled) and all(cell.startswith(("[", "(")) for cell in filled)
    )


def _bare(cell: str) -> str:
    return cell.strip("[]() ")


def _is_text(cells: Sequence[str], width: int, is_number: Callable[[str], bool]) -> bool:
    """Return whether a line has a cell for each column, and words in at least one."""
    filled = [cell for cell in cells if cell.strip()]
    words = [cell for cell in filled if not is_number(cell) and any(map(str.isalpha, cell))]
    return len(cells) == width and bool(words)
