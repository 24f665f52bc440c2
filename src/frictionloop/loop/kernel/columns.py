"""One number per lane, or one for all of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import repeat
from operator import is_
from typing import Any

import numpy as np


def distinct(lanes: Sequence[Any]) -> Sequence[Any]:
    """Return what the lanes hold, but only once if all hold the same object: what a sweep leaves alone is shared."""
    return lanes[:1] if all(map(is_, lanes, repeat(lanes[0]))) else lanes


def column(lanes: Sequence[Any], of: Callable[[Any], Any]) -> np.ndarray:
    """Return ``of`` each lane, shape (numbers, lanes), or (lanes,) if ``of`` gives a single number.

    Lanes that share one object get one column, which numpy spreads over them.
    """
    return np.array([of(lane) for lane in distinct(lanes)]).T
