"""Text files as tables: each column a channel, each cell that is no number a gap, each row left out told."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding
from frictionloop.recordings.contents import Channel, Contents, Spool, blocks_of, is_large, left_out
from frictionloop.recordings.table_layout import Layout, Row, cells_of, is_row, layout_of, rates_in, unit_in
from frictionloop.recordings.text_numbers import (
    OTHER,
    Decimal,
    header,
    is_time,
    number_in,
    seconds_after,
    shown,
    told_date,
)

Table = NDArray[np.float64]
CHUNK = 2**24
"""Characters that are parsed at once."""
_NO_ROW = re.compile(r'^[ \t,;"\0]*(?:(?:#|sep=).*)?$', re.MULTILINE)
"""A line that `is_row` denies."""


def read_table(path: Path, decimal: Decimal | None = None) -> Contents:
    """Return the columns of a text file; a column without a name is called by its number."""
    layout = layout_of(path, decimal)
    found, blank = list[Finding](), list[int]()
    if layout.taken:
        found.append(Finding("TAKEN-FOR", value="comma", more={"path": "decimal"}))
    if 0 < layout.named < layout.width:
        found.append(Finding("NAMES-FEWER", value=layout.named, limit=layout.width))
    tables = _tables(path, layout, blank)
    if is_large(path, path.stat().st_size, 1):
        spool = Spool(layout.width)
        for table in tables:
            spool.add(table)
        columns: list[Any] = list(spool.columns())
    else:
        columns = list(np.concatenate([*tables]).T)
    if blank:
        where = Condition(channel=f"line {blank[0]}" if len(blank) == 1 else f"lines {blank[0]} ...")
        found.append(Finding("LEFT-OUT", value=len(blank), where=where, more={"reason": f"blank, {len(blank)} in all"}))
    channels = [*_with_times([*_channels(path, layout, columns)])]
    empty = [each for each in channels if np.all(np.isnan(next(blocks_of(each.samples))))]
    named = [each for each in empty if each.name != str(each.number)]
    found += [left_out(each.name, "no times there" if each.tells_time else "no numbers there") for each in named]
    date = told_date([(each.name, each.value) for each in layout.said])
    date = date or next((shown(start) for _, start in layout.begun), "")
    return Contents(tuple(each for each in channels if not any(each is other for other in empty)), tuple(found), date)


def _tables(path: Path, layout: Layout, blank: list[int]) -> Iterator[Table]:
    """Yield the rows of a file in large parts; the lines between them that hold none are added to ``blank``."""
    waiting: list[int] = []
    with open(path, encoding=layout.encoding, errors="replace", newline=None) as stream:
        at = 1 + sum(1 for _ in islice(iter(stream.readline, ""), layout.first))
        while text := stream.read(CHUNK):
            text += stream.readline()
            lines = text.split("\n") if _NO_ROW.search(text.rstrip("\n")) else []
            for k, line in enumerate(lines):
                if is_row(line):
                    blank += waiting
                    waiting = []
                elif k < len(lines) - 1 and not line.lstrip().startswith("#"):
                    waiting.append(at + k)
            at += text.count("\n")
            if kept := list(filter(is_row, lines)) or ([text] if not lines else []):
                yield _rows(kept, layout)


def _channels(path: Path, layout: Layout, columns: Sequence[Any]) -> Iterator[Channel]:
    """Yield the columns."""
    names = [header(name).name for name in layout.names]
    signals = sum(not is_time(name) for name in layout.names)
    rates, begun = rates_in(layout.said), dict(layout.begun)
    for k, (name, samples) in enumerate(zip(layout.names, columns, strict=True)):
        said, doubt = unit_in(layout.said, name, signals)
        unit = "s" if k in begun else header(name).unit or said
        shown = f"{names[k]} {k}" if layout.names.count(name) > 1 else names[k]
        doubt = "" if unit else doubt
        row = partial(_place, path, layout, k)
        yield Channel(shown, samples, unit, rates_hz=rates, number=k, is_clock=k in begun, unit_in_doubt=doubt, row=row)


def _with_times(channels: Sequence[Channel]) -> Iterator[Channel]:
    """Yield columns with the times that count for them: on their left, or the first; of times side by side one."""
    clocks = [k for k, each in enumerate(channels) if each.tells_time and not (k and channels[k - 1].tells_time)]
    for k, each in enumerate(channels):
        left = [at for at in clocks if at < k] or clocks
        yield each if each.tells_time or not clocks else replace(each, times=channels[left[-1]])


def _place(path: Path, layout: Layout, k: int, i: int) -> str:
    """Return where row i of column k stands, and what is there."""
    with open(path, encoding=layout.encoding, errors="replace", newline=None) as stream:
        rows = (each for each in islice(enumerate(stream), layout.first, None) if is_row(each[1]))
        number, line = next(islice(rows, i, None))
    row = Row(number, cells_of(line, layout.mark))
    name = layout.names[k] if k < layout.named and layout.names[k] != str(k) else f"column {k}"
    if row.width > layout.width:
        return f"line {row.line + 1}: {name} is in a row of {row.width} cells, of {layout.width} columns"
    cell = row.cells[k].strip() if k < len(row.cells) else ""
    hint = f"; decimal = {OTHER[layout.decimal]!r}?" if OTHER[layout.decimal] in cell else ""
    return f"line {row.line + 1}: {name} is {f'{cell!r:.40}' if cell else 'blank'}{hint}"


def _rows(lines: list[str], layout: Layout) -> Table:
    """Return the numbers of rows, shape (rows, columns); quickly where the table is whole, else cell by cell."""
    try:
        return _quick(StringIO("\n".join(lines)), layout)
    except ValueError:
        return _cell_by_cell(lines if len(lines) > 1 else lines[0].rstrip("\n").split("\n"), layout)


def _quick(stream: Any, layout: Layout) -> Table:
    """Return the numbers by the reader of pandas; ValueError where a cell is no number or a row is too long."""
    import pandas  # type: ignore[import-untyped]

    texts: dict[int, Any] = {k: str for k, _ in layout.begun}
    frame = pandas.read_csv(
        stream,
        header=None,
        index_col=False,
        sep=r"\s+" if layout.mark == " " else layout.mark,
        decimal=layout.decimal,
        comment="#",
        skipinitialspace=True,
        dtype=defaultdict(lambda: np.float64, texts) if texts else np.float64,
        encoding=layout.encoding,
        encoding_errors="replace",
        engine="c",
    )
    spare = frame.iloc[:, layout.width :]
    if len(spare.columns) and not spare.isna().to_numpy().all():
        raise ValueError("a row is too long")
    frame = frame.reindex(columns=range(layout.width))
    for k, start in layout.begun:
        frame[k] = seconds_after(start, map(str, frame[k]))
    return np.asarray(frame.to_numpy(), dtype=float)


def _cell_by_cell(lines: Iterable[str], layout: Layout) -> Table:
    rows = [Row(0, cells_of(line, layout.mark)) for line in lines]
    values = np.full((len(rows), layout.width), np.nan)
    begun = dict(layout.begun)
    for k, row in enumerate(rows):
        if row.width <= layout.width:
            for j, cell in enumerate(row.cells[: layout.width]):
                values[k, j] = np.nan if j in begun else number_in(cell, layout.decimal)
    for j, start in begun.items():
        values[:, j] = seconds_after(start, [row.cells[j] if j < len(row.cells) else "" for row in rows])
    return values
