"""Text files as whole tables: preamble, one or two rows of names, units, quoted cells, decimal commas, ragged rows."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Finding
from frictionloop.quantities import must_be
from frictionloop.recordings import stored
from frictionloop.recordings.contents import Channel, Contents, left_out, told_date
from frictionloop.recordings.headers import header, is_time
from frictionloop.recordings.preamble import names_only, rates_in, said_in, unit_in
from frictionloop.recordings.stamps import shown
from frictionloop.recordings.stored import Samples, Stored, blocks_of, is_large
from frictionloop.recordings.table_layout import Layout, layout_of, names_of
from frictionloop.recordings.table_rows import all_rows, rows_in
from frictionloop.recordings.text_index import Index, bytes_of, indexed

MOST_COLUMNS = 10_000
"""More than any recorder writes (assumed)."""


def read_table(path: Path) -> Contents:
    """Return the columns of a text file; a cell that is no number is NaN, and a column without a name its number."""
    layout = layout_of(path)
    _check_width(path, layout.width)
    if is_large(path, path.stat().st_size, 1) and layout.encoding != "utf-16":
        index = indexed(path, layout.first)
        read = partial(_block, path, path.stat().st_mtime_ns, layout, index)
        width = read(0, min(1000, index.rows)).shape[1]
        lines: list[Samples] = [Stored(index.rows, np.dtype(float), partial(_column, read, k)) for k in range(width)]
    else:
        values = all_rows(path, layout)
        width = values.shape[1]
        _check_width(path, width)
        lines = [values[:, k] for k in range(width)]
    names = names_of(names_only(layout.head, layout.above), max(layout.width, width))
    said = said_in(layout.above)
    signals = sum(not is_time(name) for name in names)
    begun = dict(layout.begun)
    empty = [k for k in range(width) if np.all(np.isnan(next(blocks_of(lines[k]))))]
    channels = tuple(
        Channel(header(name).name, lines[k], "s" if k in begun else header(name).unit or unit_in(said, name, signals))
        for k, name in enumerate(names)
        if k < width and k not in empty
    )
    date = told_date([(each.name, each.value) for each in said]) or next(map(shown, begun.values()), "")
    found = [left_out(names[k], "cells hold no times") for k in empty if is_time(names[k])]
    found += [Finding("TAKEN-FOR", value=",", more={"path": "--disturbance.decimal"})] * (layout.decimal == ",")
    return Contents(channels, rates_in(said), tuple(found), date, tuple(header(names[k]).name for k in begun))


def _check_width(path: Path, width: int) -> None:
    if width > MOST_COLUMNS:
        raise must_be(f"{path}: columns", width, f"at most {MOST_COLUMNS}")


def _column(read: Callable[[int, int], NDArray[np.float64]], k: int, first: int, stop: int) -> NDArray[np.float64]:
    return read(first, stop)[:, k]


def _block(path: Path, changed: int, layout: Layout, index: Index, first: int, stop: int) -> NDArray[np.float64]:
    """Return rows of a large table, all of one block."""
    block, start = divmod(first, stored.BLOCK)
    found = _parsed(path, changed, layout.mark, layout.decimal, layout.encoding, index, block, layout.begun)
    wanted = min(stored.BLOCK, index.rows - block * stored.BLOCK)
    if len(found) != wanted:
        lines = f"lines {layout.first + first + 1} to {layout.first + first + wanted}"
        raise must_be(f"{path}: rows in {lines}", len(found), f"{wanted} in so large a table")
    return found[start : start + stop - first]


@lru_cache(2)
def _parsed(
    path: Path, _changed: int, mark: str, decimal: str, encoding: str, index: Index, block: int, begun: tuple[Any, ...]
) -> NDArray[np.float64]:
    return rows_in(path, bytes_of(path, index, block), Layout(encoding, mark, decimal, 0, [], 0, (), begun))
