"""Where the rows of a large text file stand, so that a block of them can be read without those before."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictionloop.recordings import stored

CHUNK = 2**24
"""Bytes that are looked through at once for ends of lines."""


class Index(NamedTuple):
    """The rows of a text file below its head."""

    rows: int
    offsets: tuple[int, ...]
    """Byte at which each block of rows begins, and the end of the file."""


def indexed(path: Path, first_line: int) -> Index:
    """Return where blocks of rows begin; every line from ``first_line`` on, counted from 0, is a row."""
    return _indexed(path, path.stat().st_mtime_ns, first_line, stored.BLOCK)


@lru_cache(4)
def _indexed(path: Path, _changed: int, first_line: int, block: int) -> Index:
    ends, at = 0, 0
    offsets = [] if first_line else [0]
    last = b"\n"
    with open(path, "rb") as stream:
        while chunk := stream.read(CHUNK):
            # Lines first_line + k * block begin after as many ends of lines.
            places = np.flatnonzero(np.frombuffer(chunk, np.uint8) == ord("\n"))
            wanted = np.arange(-(-(ends + 1 - first_line) // block) * block + first_line, ends + places.size + 1, block)
            offsets += [at + int(places[k - ends - 1]) + 1 for k in wanted.tolist() if k >= max(first_line, 1)]
            ends, at, last = ends + places.size, at + len(chunk), chunk[-1:]
    lines = ends + (last != b"\n")
    rows = lines - first_line
    return Index(rows, (*offsets[: -(-rows // block)], at))


def bytes_of(path: Path, index: Index, block: int) -> bytes:
    """Return the lines of a block of rows."""
    start, stop = index.offsets[block], index.offsets[block + 1]
    with open(path, "rb") as stream:
        stream.seek(start)
        return stream.read(stop - start)
