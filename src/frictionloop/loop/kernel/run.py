"""Advance a tile of systems, and let Python do something else meanwhile."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import numpy as np

from frictionloop.loop.kernel.advance import build_advance
from frictionloop.loop.kernel.lowering import Tile
from frictionloop.loop.kernel.tiles import compiled_tile


def advance(tile: Tile, start: int, stop: int, setpoint: np.ndarray, disturbance: np.ndarray, chunk: int) -> None:
    """Run a tile from one control period to another; samples of signals begin with period ``chunk``.

    Single-threaded and without the GIL: threads, Ctrl-C and progress belong to the caller.
    """
    tile.shared.point(setpoint_samples=setpoint, disturbance_samples=disturbance)
    tile.shared.set(chunk=chunk)
    _loop()(tile.slab.data.ctypes.data, start, stop, tile.shared.address)
    if tile.shared.python is not None and tile.shared.python.error is not None:
        raise tile.shared.python.error


@cache
def _loop() -> Any:
    """Return the compiled loop; it knows no lanes and serves every width."""
    whole, address = ctypes.c_int64, ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, address, whole, whole, address)(compiled_tile(build_advance, 1).address)
