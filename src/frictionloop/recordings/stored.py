"""Samples that stay in their file until they are asked for: what a recording larger than the memory is read by."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

LARGE_BYTES = 2**26
"""A file, or an array unpacked, above this size stays where it is; a smaller one is read whole (64 MiB)."""
BLOCK = 2**17
"""Rows that are read at once: of eight channels in double precision 8 MiB."""


@dataclass(frozen=True)
class Stored:
    """One line of samples in a file: ``stored[a:b]`` reads rows a to b, ``np.asarray(stored)`` all of them."""

    size: int
    dtype: np.dtype[Any]
    fetch: Callable[[int, int], NDArray[Any]]
    """Returns rows a to b of one block."""

    def __getitem__(self, rows: slice) -> NDArray[Any]:
        first, stop, step = rows.indices(self.size)
        if stop <= first or first // BLOCK == (stop - 1) // BLOCK:
            return self.fetch(first, max(stop, first))[::step]
        found = np.empty(stop - first, self.dtype)
        for start in range(first // BLOCK * BLOCK, stop, BLOCK):
            inside = slice(max(first - start, 0), min(stop - start, BLOCK))
            block = self.fetch(start, min(start + BLOCK, self.size))[inside]
            found[start + inside.start - first :][: block.size] = block
        return found[::step]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self[:], dtype)


Samples = NDArray[Any] | Stored


def is_large(path: Path, size: int, itemsize: int = 8) -> bool:
    """Return whether an array of a file is to stay there."""
    return size > BLOCK and max(path.stat().st_size, size * itemsize) > LARGE_BYTES


def blocks_of(samples: Samples) -> Iterator[NDArray[Any]]:
    """Yield samples in blocks; of an array that is in the memory anyway, one."""
    if isinstance(samples, Stored):
        for start in range(0, samples.size, BLOCK):
            yield samples[start : start + BLOCK]
    else:
        yield samples


def count_blocks(samples: Samples) -> int:
    """Return how many blocks `blocks_of` yields."""
    return -(-samples.size // BLOCK) if isinstance(samples, Stored) else 1


CHUNK = 2**24
"""Bytes that are looked through at once for ends of lines."""


class Index(NamedTuple):
    """The rows of a text file below its head."""

    rows: int
    offsets: tuple[int, ...]
    """Byte at which each block of rows begins, and the end of the file."""


def indexed(path: Path, first_line: int) -> Index:
    """Return where blocks of rows begin; every line from ``first_line`` on, counted from 0, is a row."""
    return _indexed(path, path.stat().st_mtime_ns, first_line, BLOCK)


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
