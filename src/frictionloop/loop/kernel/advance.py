"""The loop itself: it fills a block of signals, and runs the tiles of each period in their order."""

from __future__ import annotations

from typing import Any

from frictionloop.loop.kernel.access import call_tile, peek, wholes
from frictionloop.loop.kernel.shared import pointer_to
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import step
from frictionloop.quantities.normals import BLOCK


@step
def run_program(s: Any, k: int, at: int, program: int, count: int, o: Any) -> None:
    """Call the tiles of a program one after another."""
    for j in range(count):
        call_tile(peek(wholes(program), j), s, k, at, pointer_to(o))


def build_advance(lifting: Lifting) -> Any:
    """Return the loop from period ``start`` to ``stop``; it is single-threaded and called for chunks of time."""

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
                call_tile(o.whole, s, k, end, pointer_to(o))
                k = end
            while k < end:
                if k > entered:
                    run_program(s, k - 1, 0, o.obeys, o.obeys_count, o)
                run_program(s, k, k - first, o.ticks, o.ticks_count, o)
                k += 1

    return advance
