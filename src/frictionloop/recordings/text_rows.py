"""Lines of a text file as rows of cells: what parts them, which are comments, and what the first ones tell."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from itertools import islice

from frictionloop.recordings.preamble import Said, said_in
from frictionloop.recordings.text_head import LOOKED_AT, Row


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
