"""Rows of a text table as numbers: quickly where the table is whole, cell by cell where it is not."""

from __future__ import annotations

from collections import defaultdict
from io import BytesIO, TextIOWrapper
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.hdf5 import expands
from frictionloop.recordings.stamps import seconds_after
from frictionloop.recordings.table_layout import NUMBER, Layout, cells_of


def all_rows(path: Path, layout: Layout) -> NDArray[np.float64]:
    """Return the numbers of a file below its head, shape (rows, columns); NaN where there is none."""
    with open(path, "rb") as stream:
        found = _quick(stream, layout, layout.first)
    if found is not None:
        return found
    with open(path, encoding=layout.encoding, errors="replace", newline="") as text:
        lines = [line for line in islice(text, layout.first, None) if line.strip()]
    return _cell_by_cell(lines, layout, path)


def rows_in(path: Path, raw: bytes, layout: Layout) -> NDArray[np.float64]:
    """Return the numbers of whole lines of a file, shape (rows, columns)."""
    found = _quick(BytesIO(raw), layout, 0)
    if found is not None:
        return found
    lines = TextIOWrapper(BytesIO(raw), layout.encoding, "replace", "")
    return _cell_by_cell([line for line in lines if line.strip()], layout, path)


def _quick(stream: BytesIO | object, layout: Layout, skip: int) -> NDArray[np.float64] | None:
    """Return the numbers by the reader of pandas, None where a cell is no number or a row is longer than the first."""
    import pandas  # type: ignore[import-untyped]

    try:
        frame = pandas.read_csv(
            stream,
            header=None,
            index_col=False,
            sep=r"\s+" if layout.mark == " " else layout.mark,
            decimal=layout.decimal,
            skiprows=skip,
            comment="#",
            skipinitialspace=True,
            dtype=_types(layout),
            encoding=layout.encoding,
            encoding_errors="replace",
            engine="c",
        )
    except (ValueError, pandas.errors.ParserError):
        return None
    for k, start in layout.begun:
        frame[k] = seconds_after(start, map(str, frame[k]))
    return np.asarray(frame.to_numpy(), dtype=float)


def _types(layout: Layout) -> Any:
    """Return the type of every column for pandas: texts where there are time stamps."""
    texts: dict[int, Any] = {k: str for k, _ in layout.begun}
    return defaultdict(lambda: np.float64, texts) if texts else np.float64


def _cell_by_cell(lines: list[str], layout: Layout, path: Path) -> NDArray[np.float64]:
    rows = [cells_of(line.rstrip("\r\n"), layout.mark) for line in lines]
    width = max(map(len, rows))
    if wrong := expands(path.stat().st_size, 8 * len(rows) * width):
        raise FrictionloopError(f"{path}: has a row of {width} cells, and {wrong}")
    values = np.full((len(rows), width), np.nan)
    for k, row in enumerate(rows):
        for j, cell in enumerate(row):
            text = cell.strip().replace(layout.decimal, ".")
            if NUMBER.fullmatch(text):
                values[k, j] = float(text)
    for j, start in layout.begun:
        values[:, j] = seconds_after(start, [row[j] if j < len(row) else "" for row in rows])
    return values
