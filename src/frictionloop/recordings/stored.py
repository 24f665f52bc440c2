"""Samples that stay in their file until they are asked for: what a recording larger than the memory is read by."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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
