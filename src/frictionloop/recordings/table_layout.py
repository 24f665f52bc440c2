"""How a text file is written: encoding, what parts its cells, the decimal mark, names, where its numbers begin."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictionloop.quantities import must_be
from frictionloop.recordings.headers import said_unit
from frictionloop.recordings.stamps import is_stamp, stamp_of

LOOKED_AT = 200
"""Lines in which names must end and numbers begin (assumed)."""
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(nan|inf)", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")


class Layout(NamedTuple):
    """How a text file is written."""

    encoding: str
    mark: str
    decimal: str
    first: int
    """Line at which the numbers begin, counted from 0."""
    head: list[list[str]]
    """Cells of the lines before."""
    width: int
    above: tuple[str, ...] = ()
    """Those lines as they stand."""
    begun: tuple[tuple[int, np.datetime64], ...] = ()
    """Columns of times of the clock on the wall, and the first of each: they are read in s after it."""


def layout_of(path: Path) -> Layout:
    """Return how a file is written, by its first lines; refuses one without a row of numbers there."""
    encoding = _encoding(path)
    with open(path, encoding=encoding, errors="replace", newline="") as stream:
        lines = [line.rstrip("\r\n") for line in islice(stream, LOOKED_AT)]
    filled = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not filled:
        raise must_be(f"{path}: rows of numbers", 0, "1 or more")
    mark = next((each for each in "\t;" if each in filled[-1]), "")
    cells_with_comma = [part for part in re.split(r"[\t; ]+", filled[-1].strip()) if _COMMA.fullmatch(part.strip('"'))]
    # 1,5;2,5 and lines apart by spaces have decimal commas; 1,5 alone is two columns.
    spaced = not mark and " " in filled[-1].strip() and len(cells_with_comma) > 1
    decimal = "," if cells_with_comma and (mark or spaced) else "."
    mark = mark or ("," if "," in filled[-1] and not spaced else " " if " " in filled[-1].strip() else "\t")
    rows = [cells_of(line, mark) for line in lines]
    first = next((k for k, row in enumerate(rows) if _is_data(row, decimal) and not lines[k].startswith("#")), None)
    if first is None:
        raise must_be(f"{path}: rows of numbers", 0, f"some within {len(lines)} lines")
    head = [[cell.strip().strip('"') for cell in row] for row in rows[:first]]
    widths = [len(row) for row in rows[first:]]
    begun = tuple((k, stamp_of(cell)) for k, cell in enumerate(rows[first]) if is_stamp(cell))
    return Layout(encoding, mark, decimal, first, head, max(widths), tuple(lines[:first]), begun)


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


def cells_of(line: str, mark: str) -> list[str]:
    """Return the cells of a line."""
    if mark == " ":
        return line.split()
    return next(csv.reader([line], delimiter=mark), [])


def _is_data(row: Sequence[str], decimal: str) -> bool:
    """Return whether at least half of the cells that are filled, and the first or second, are numbers or times."""
    filled = [cell.strip() for cell in row if cell.strip()]
    numbers = [NUMBER.fullmatch(cell.replace(decimal, ".")) is not None or is_stamp(cell) for cell in filled]
    return bool(filled) and any(numbers[:2]) and 2 * sum(numbers) > len(numbers)


def names_of(head: list[list[str]], count: int) -> list[str]:
    """Return a name for each column, from the last rows of the head that have about as many cells."""
    rows = [row for row in head if sum(bool(cell) for cell in row) > (1 if count > 1 else 0)]
    wide = [row for row in rows if abs(len(row) - count) <= max(1, count // 2)] or rows[-1:]
    units: list[str] = []
    if len(wide) > 1 and _are_units(wide[-1]):
        units = [cell.strip("[]() ") for cell in wide.pop()]
    names = [cell.lstrip("# ") for cell in wide[-1]] if wide else []
    if len(wide) > 1 and len(wide[-2]) == len(names) and not any(NUMBER.fullmatch(cell) for cell in wide[-2]):
        names = _under_groups([cell.lstrip("# ") for cell in wide[-2]], names)
    if names and names[0] == "" and len(names) == count + 1:
        names = names[1:]
    names = (names + [""] * count)[:count]
    units = (units + [""] * count)[:count]
    named = [
        f"{name or k} [{unit}]" if unit else name or str(k)
        for k, (name, unit) in enumerate(zip(names, units, strict=True))
    ]
    first = {name: k for k, name in reversed([*enumerate(named)])}
    return [name if first[name] == k else f"{name} {k}" for k, name in enumerate(named)]


def _are_units(row: list[str]) -> bool:
    filled = [cell.strip("[]() ") for cell in row if cell.strip("[]() -")]
    bracketed = [cell for cell in row if cell.strip().startswith(("[", "("))]
    return bool(filled) and (
        2 * sum(said_unit(cell) is not None for cell in filled) >= len(filled) or len(bracketed) == len(filled)
    )


def _under_groups(groups: list[str], names: list[str]) -> list[str]:
    """Return "group name" where names stand under groups; below a blank cell the group before goes on."""
    joined, group = [], ""
    for above, name in zip(groups, names, strict=True):
        group = above or group
        joined.append(f"{group} {name}".strip() if group != name else name)
    return joined
