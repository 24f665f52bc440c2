"""Sensor noise for one block of control periods, drawn inside the kernel, ``[period of the block][lane]``."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.loop.kernel.slab_access import peek, poke
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.quantities.arithmetic import bits, double
from frictionloop.quantities.normals import BLOCK, box_muller, draw_words

NOISE_STREAM = np.uint64(0)
"""Stream number of the sensor noise; other noises have streams of their own."""


def build_noise(lifting: Lifting) -> Any:
    """Return the compiled ``fill_noise`` for the tiles of a kernel."""
    width, compiled, _ = lifting

    @compiled
    def scatter(out, at, apart, words):  # type: ignore[no-untyped-def]
        poke(out, at, double(np.int64(words[0])))
        poke(out, at + apart, double(np.int64(words[1])))
        poke(out, at + 2 * apart, double(np.int64(words[2])))
        poke(out, at + 3 * apart, double(np.int64(words[3])))

    @compiled
    def fill_noise(out, at, seeds, shared, first, counters, stream):  # type: ignore[no-untyped-def]
        # ``counters`` is always BLOCK // 4, but as a constant the loop would be unrolled instead of vectorised.
        # First all words, then all normals: in one loop the processor would see too little of either ahead.
        base = first // BLOCK * counters
        columns = 1 if shared else width
        apart = 8 * columns
        if shared:
            seed = peek(seeds, 0)
            for c in range(counters):
                scatter(out, at + c, apart, draw_words(seed, stream, np.uint64(base + c)))
        else:
            for c in range(counters):
                counter = np.uint64(base + c)
                for i in range(width):
                    scatter(out, at + c * width + i, apart, draw_words(peek(seeds, i), stream, counter))
        for half in range(2):
            begin = at + 2 * half * apart
            for j in range(counters * columns):
                z0, z1 = box_muller(
                    np.uint64(bits(peek(out, begin + j))), np.uint64(bits(peek(out, begin + apart + j)))
                )
                poke(out, begin + j, z0)
                poke(out, begin + apart + j, z1)

    return fill_noise
