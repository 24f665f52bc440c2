"""Unit normals for one block of control periods, drawn inside the kernel, ``[period of the block][lane]``."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.loop.kernel.access import doubles, keys, peek, poke
from frictionloop.loop.kernel.tiles import Lifting
from frictionloop.physics.tremor import NORMAL_STREAM, TANGENTIAL_STREAM
from frictionloop.quantities.arithmetic import bits, double
from frictionloop.quantities.normals import BLOCK, box_muller, draw_words
from frictionloop.sensing.touch import LOAD_STREAM, POSITION_STREAM

JITTER_STREAM, LOST_STREAM = 24, 25
"""Streams of the counter-based noise that make commands late and lose ticks."""
STREAMS = {
    "normals": (0,),  # of the sensor
    "draws": (TANGENTIAL_STREAM, NORMAL_STREAM, POSITION_STREAM, LOAD_STREAM),
    "timing": (JITTER_STREAM, LOST_STREAM),
}
"""What is drawn, by the buffer that it goes to: one stream after another."""


def build_draws(lifting: Lifting, buffer: str) -> Any:
    """Return the tile that draws all streams of a buffer."""
    width, compiled, _ = lifting
    streams = tuple(np.uint64(stream) for stream in STREAMS[buffer])
    sensor, moving = buffer == "normals", buffer == "draws"

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

    @compiled
    def draws(s, n, first, periods, o):  # type: ignore[no-untyped-def]
        out = doubles(o.normals if sensor else (o.draws if moving else o.timing))
        counters = BLOCK // 4 if n > 0 else 0
        columns = BLOCK if o.noise_shared else BLOCK * width
        for j in range(len(streams)):
            fill_noise(out, j * columns, keys(o.seeds), o.noise_shared, first, counters, streams[j])

    return draws
