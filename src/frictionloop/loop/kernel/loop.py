"""The loop itself: it fills a block of signals, and runs the tiles of each period in their order.

Single-threaded and without the GIL: threads, Ctrl-C and progress belong to the caller.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from frictionloop.loop.kernel.slab_access import call, load, wholes
from frictionloop.loop.kernel.slab_columns import Slab
from frictionloop.loop.kernel.step_lifting import Lifting, compiled_tile
from frictionloop.loop.kernel.tile_record import Shared, pointer_to
from frictionloop.loop.metric import Tally
from frictionloop.physics.signal_values import Sampler
from frictionloop.quantities.counter_noise import BLOCK
from frictionloop.quantities.scalar_math import step


@step
def run_program(s: Any, k: int, at: int, program: int, count: int, o: Any) -> None:
    """Call the tiles of a program one after another."""
    for j in range(count):
        call(load(wholes(program), 0, 1, j), (s, k, at, pointer_to(o)))


def build_advance(lifting: Lifting) -> Any:
    """Return the loop from period ``start`` to ``stop``."""

    @lifting.compiled
    def advance(s, n, start, stop, o):  # type: ignore[no-untyped-def]
        k = start
        while k < stop:
            first = k // BLOCK * BLOCK
            end, entered = min(stop, first + BLOCK), k
            # A command from outside comes after the measurement: its period runs when the next sample is due.
            if k > 0:
                run_program(s, k - 1, 0, o.obeys, o.obeys_count, o)
            run_program(s, first, end - first, o.blocks, o.blocks_count, o)
            if o.whole != 0:
                call(o.whole, (s, k, end, pointer_to(o)))
                k = end
            while k < end:
                if k > entered:
                    run_program(s, k - 1, 0, o.obeys, o.obeys_count, o)
                run_program(s, k, k - first, o.ticks, o.ticks_count, o)
                k += 1

    return advance


@cache
def _loop() -> Any:
    """Return the compiled loop; it knows no lanes and serves every width."""
    whole, address = ctypes.c_int64, ctypes.c_void_p
    return ctypes.CFUNCTYPE(None, address, whole, whole, address)(compiled_tile(1, build_advance))


@dataclass(frozen=True)
class Tile:
    """Lanes of one structure, ready to run."""

    kernel: str
    slab: Slab
    shared: Shared
    setpoint: Sampler
    disturbance: Sampler
    places: Mapping[Tally, int]
    """First row of each tally."""

    def advance(self, start: int, stop: int, setpoint: np.ndarray, disturbance: np.ndarray, chunk: int) -> None:
        """Run from one control period to another; samples of signals begin with period ``chunk``."""
        self.shared.point(setpoint_samples=setpoint, disturbance_samples=disturbance)
        self.shared.set(chunk=chunk)
        _loop()(self.slab.data.ctypes.data, start, stop, self.shared.record.ctypes.data)
        if self.shared.python is not None and self.shared.python.error is not None:
            raise self.shared.python.error
