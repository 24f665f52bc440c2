"""Lanes as columns of a slab: one array for the state of a tile (structure of arrays)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import repeat
from operator import is_
from typing import Any

import numpy as np

from frictionloop.loop.kernel.slab import ROW, ROWS
from frictionloop.quantities.flat_tuples import flat


def distinct(lanes: Sequence[Any]) -> Sequence[Any]:
    """Return what the lanes hold, but only once if all hold the same object: what a sweep leaves alone is shared."""
    return lanes[:1] if all(map(is_, lanes, repeat(lanes[0]))) else lanes


def column(lanes: Sequence[Any], of: Callable[[Any], Any]) -> np.ndarray:
    """Return ``of`` each lane, shape (numbers, lanes), or (lanes,) if ``of`` gives a single number.

    Lanes that share one object get one column, which numpy spreads over them.
    """
    return np.array([of(lane) for lane in distinct(lanes)]).T


def aligned(size: int) -> np.ndarray:
    """Return zeros that begin on a cache line: a vector of 8 doubles then never straddles two."""
    line = 64
    room = np.zeros(size + line // 8)
    start = -room.ctypes.data % line // 8
    return room[start : start + size]


def _span(numbers: Any) -> slice:
    """Return the rows from the first to the last of row numbers."""
    adjoining = flat((numbers,))
    return slice(adjoining[0], adjoining[-1] + 1)


_SPANS = {name: _span(numbers) for name, numbers in ROW.items()}


class Slab:
    """The rows of one tile; ``width`` is 1 for a single lane, else ``LANES``."""

    def __init__(self, width: int, rows: int = ROWS) -> None:
        self.width = width
        self.data = aligned(rows * width)
        self._rows = self.data.reshape(rows, width)

    def view(self, of: Any) -> np.ndarray:
        """Return rows as a view of shape (count, width): those of a quantity by its name, or adjoining row numbers."""
        return self._rows[_SPANS[of] if isinstance(of, str) else _span(of)]

    def fill(self, of: Callable[[Any], dict[Any, Any]], lanes: Sequence[Any]) -> None:
        """Set the rows that ``of`` gives for each lane, by name or row numbers, to a number or tuples of numbers."""
        found = [of(lane) for lane in distinct(lanes)]
        for rows, first in found[0].items():
            values = [each[rows] for each in found]
            if isinstance(first, tuple) and any(isinstance(part, tuple) for part in first):
                values = [flat(value) for value in values]
            self.view(rows)[:] = np.array(values, float).reshape(len(found), -1).T
