"""Samples that stay in a file until they are asked for: what a recording larger than the memory is read by."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any
from weakref import finalize

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


class Spool:
    """Rows of numbers in a file without a name: a text that is too large for the memory is parsed once."""

    def __init__(self, width: int) -> None:
        self._file, self._width, self._rows = TemporaryFile(), width, 0  # noqa: SIM115
        finalize(self, self._file.close)

    def add(self, rows: NDArray[np.float64]) -> None:
        """Keep rows, shape (rows, columns)."""
        rows.tofile(self._file)
        self._rows += len(rows)

    def columns(self) -> list[Stored]:
        """Return each column of what was kept."""
        self._file.flush()
        return [Stored(self._rows, np.dtype(float), partial(self._read, k)) for k in range(self._width)]

    def _read(self, k: int, first: int, stop: int) -> NDArray[np.float64]:
        self._file.seek(8 * first * self._width)
        return np.fromfile(self._file, float, (stop - first) * self._width).reshape(-1, self._width)[:, k]
