"""Text files as whole tables: preamble, one or two rows of names, units, quoted cells, decimal commas, ragged rows."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.units import known_unit
from frictionloop.recordings.contents import Channel, Contents, told_date, told_rates
from frictionloop.recordings.headers import header

LOOKED_AT = 200
"""Lines in which names must end and numbers begin (assumed)."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf)", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")


class _Layout(NamedTuple):
    """How a text file is written."""

    encoding: str
    mark: str
    decimal: str
    first: int
    """Line at which the numbers begin, counted from 0."""
    head: list[list[str]]
    """Cells of the lines before."""
    width: int


def read_table(path: Path) -> Contents:
    """Return the columns of a text file; a cell that is no number is NaN, and a column without a name its number."""
    layout = _layout(path)
    values = _values(path, layout)
    names = _names(layout.head, max(layout.width, values.shape[1]))
    pairs = [(row[0].lstrip("# ").rstrip(":= "), row[1]) for row in layout.head if len(row) > 1]
    pairs += [(found[0], found[1]) for row in layout.head if len(row) == 1 and len(found := _halves(row[0])) == 2]
    channels = tuple(
        Channel(header(name).name, values[:, k], header(name).unit)
        for k, name in enumerate(names)
        if k < values.shape[1] and not np.all(np.isnan(values[:, k]))
    )
    return Contents(channels, told_rates(pairs), date=told_date(pairs))


def _halves(text: str) -> list[str]:
    return [part.strip() for part in re.split(r"[:=]", text.lstrip("# "), maxsplit=1)]


def _layout(path: Path) -> _Layout:
    encoding = _encoding(path)
    with open(path, encoding=encoding, errors="replace", newline="") as stream:
        lines = [line.rstrip("\r\n") for line in islice(stream, LOOKED_AT)]
    filled = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not filled:
        raise FrictionloopError(f"{path}: is empty; accepted: rows of numbers")
    mark = next((each for each in "\t;" if each in filled[-1]), "")
    cells_with_comma = [part for part in re.split(r"[\t; ]+", filled[-1].strip()) if _COMMA.fullmatch(part.strip('"'))]
    # 1,5;2,5 and lines apart by spaces have decimal commas; 1,5 alone is two columns.
    spaced = not mark and " " in filled[-1].strip() and len(cells_with_comma) > 1
    decimal = "," if cells_with_comma and (mark or spaced) else "."
    mark = mark or ("," if "," in filled[-1] and not spaced else " ")
    rows = [_cells(line, mark) for line in lines]
    first = next((k for k, row in enumerate(rows) if _is_data(row, decimal) and not lines[k].startswith("#")), None)
    if first is None:
        raise FrictionloopError(f"{path}: has no row of numbers in its first {len(lines)} lines; accepted: a table")
    head = [[cell.strip().strip('"') for cell in row] for row in rows[:first]]
    widths = [len(row) for row in rows[first:]]
    return _Layout(encoding, mark, decimal, first, head, max(widths))


def _encoding(path: Path) -> str:
    with open(path, "rb") as stream:
        start = stream.read(4096)
    if start[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    try:
        start.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return "cp1252" if error.start < len(start) - 4 else "utf-8-sig"
    return "utf-8-sig"


def _cells(line: str, mark: str) -> list[str]:
    if mark == " ":
        return line.split()
    return next(csv.reader([line], delimiter=mark), [])


def _is_data(row: Sequence[str], decimal: str) -> bool:
    """Return whether at least half of the cells that are filled, and the first or second, are numbers."""
    filled = [cell.strip() for cell in row if cell.strip()]
    numbers = [_NUMBER.fullmatch(cell.replace(decimal, ".")) is not None for cell in filled]
    return bool(filled) and any(numbers[:2]) and 2 * sum(numbers) > len(numbers)


def _values(path: Path, layout: _Layout) -> NDArray[np.float64]:
    """Return the numbers, shape (rows, columns): quickly where the table is whole, cell by cell where it is not."""
    mark = None if layout.mark == " " else layout.mark
    with open(path, encoding=layout.encoding, errors="replace", newline="") as stream:
        lines = (
            line if layout.decimal == "." else line.replace(",", ".") for line in islice(stream, layout.first, None)
        )
        try:
            return np.loadtxt(lines, delimiter=mark, ndmin=2, quotechar='"', comments="#")
        except ValueError:
            pass
    with open(path, encoding=layout.encoding, errors="replace", newline="") as stream:
        rows = [_cells(line.rstrip("\r\n"), layout.mark) for line in islice(stream, layout.first, None) if line.strip()]
    values = np.full((len(rows), max(map(len, rows))), np.nan)
    for k, row in enumerate(rows):
        for j, cell in enumerate(row):
            text = cell.strip().replace(layout.decimal, ".")
            if _NUMBER.fullmatch(text):
                values[k, j] = float(text)
    return values


def _names(head: list[list[str]], count: int) -> list[str]:
    """Return a name for each column, from the last rows of the head that have about as many cells."""
    rows = [row for row in head if sum(bool(cell) for cell in row) > (1 if count > 1 else 0)]
    wide = [row for row in rows if abs(len(row) - count) <= max(1, count // 2)] or rows[-1:]
    units: list[str] = []
    if len(wide) > 1 and _are_units(wide[-1]):
        units = [cell.strip("[]() ") for cell in wide.pop()]
    names = [cell.lstrip("# ") for cell in wide[-1]] if wide else []
    if len(wide) > 1 and len(wide[-2]) == len(names) and not any(_NUMBER.fullmatch(cell) for cell in wide[-2]):
        names = _under_groups([cell.lstrip("# ") for cell in wide[-2]], names)
    if names and names[0] == "" and len(names) == count + 1:
        names = names[1:]
    names = (names + [""] * count)[:count]
    units = (units + [""] * count)[:count]
    named = [
        f"{name or k} [{unit}]" if unit else name or str(k)
        for k, (name, unit) in enumerate(zip(names, units, strict=True))
    ]
    return [name if name not in named[:k] else f"{name} {k}" for k, name in enumerate(named)]


def _are_units(row: list[str]) -> bool:
    filled = [cell.strip("[]() ") for cell in row if cell.strip("[]() -")]
    bracketed = [cell for cell in row if cell.strip().startswith(("[", "("))]
    return bool(filled) and (
        2 * sum(known_unit(cell) is not None for cell in filled) >= len(filled) or len(bracketed) == len(filled)
    )


def _under_groups(groups: list[str], names: list[str]) -> list[str]:
    """Return "group name" where names stand under groups; below a blank cell the group before goes on."""
    joined, group = [], ""
    for above, name in zip(groups, names, strict=True):
        group = above or group
        joined.append(f"{group} {name}".strip() if group != name else name)
    return joined
