"""Numbers of lanes as rows of a slab: one for each lane, or one for all of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import repeat
from operator import is_
from typing import Any

import numpy as np

from frictionloop.loop.kernel.slab import Slab
from frictionloop.quantities.trees import flat


def distinct(lanes: Sequence[Any]) -> Sequence[Any]:
    """Return what the lanes hold, but only once if all hold the same object: what a sweep leaves alone is shared."""
    return lanes[:1] if all(map(is_, lanes, repeat(lanes[0]))) else lanes


def column(lanes: Sequence[Any], of: Callable[[Any], Any]) -> np.ndarray:
    """Return ``of`` each lane, shape (numbers, lanes), or (lanes,) if ``of`` gives a single number.

    Lanes that share one object get one column, which numpy spreads over them.
    """
    return np.array([of(lane) for lane in distinct(lanes)]).T


def fill(slab: Slab, of: Callable[[Any], dict[Any, Any]], lanes: Sequence[Any]) -> None:
    """Set the rows that ``of`` names for each lane: by names or row numbers, to a number or named tuples of numbers."""
    found = [of(lane) for lane in distinct(lanes)]
    for rows in found[0]:
        slab.view(rows)[:] = np.array([flat((each[rows],)) for each in found], float).T
