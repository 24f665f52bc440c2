"""Counter-based Gaussian noise: Philox4x32-10 and Box-Muller, a pure function of (seed, stream, period).

Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC'11 (doi 10.1145/2063384.2063405);
known answers from its Random123 library are tested. No state is carried, so any period of any lane can be drawn by any
thread, alone or in a grid, and is the same.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from frictionloop.quantities.arithmetic import cos_turns, log2, sin_turns, step
from frictionloop.quantities.compiled import SourceCache

BLOCK = 32
"""Periods per block: one call to ``draw`` serves periods c, c+8, c+16 and c+24 of a block."""

Word = np.uint64
_MULTIPLIER_0, _MULTIPLIER_1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_WEYL_0, _WEYL_1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
_SCALE = 2.0**-32
_MINUS_2_LN_2 = -2.0 * math.log(2.0)


@step
def philox(c0: Word, c1: Word, c2: Word, c3: Word, k0: Word, k1: Word) -> tuple[Word, Word, Word, Word]:
    """Return the four 32-bit words of Philox4x32-10 for a counter and a key (each a uint64 below 2**32)."""
    for _ in range(10):
        p0, p1 = _MULTIPLIER_0 * c0, _MULTIPLIER_1 * c2
        c0, c1, c2, c3 = (p1 >> _HALF) ^ c1 ^ k0, p1 & _LOW, (p0 >> _HALF) ^ c3 ^ k1, p0 & _LOW
        k0, k1 = (k0 + _WEYL_0) & _LOW, (k1 + _WEYL_1) & _LOW
    return c0, c1, c2, c3


@step
def box_muller(w0: Word, w1: Word) -> tuple[float, float]:
    """Return two independent standard normals from two 32-bit words; |z| < 6.8."""
    radius = math.sqrt(_MINUS_2_LN_2 * log2((float(w0) + 0.5) * _SCALE))
    turn = float(w1) * _SCALE
    return radius * cos_turns(turn), radius * sin_turns(turn)


@step
def draw(seed: Word, stream: Word, counter: Word) -> tuple[float, float, float, float]:
    """Return four standard normals for a 64-bit seed, a stream number and a counter (uint64)."""
    words = philox(counter & _LOW, counter >> _HALF, stream, np.uint64(0), seed & _LOW, seed >> _HALF)
    z0, z1 = box_muller(words[0], words[1])
    z2, z3 = box_muller(words[2], words[3])
    return z0, z1, z2, z3


@njit(error_model="numpy", nogil=True)
def fill_normals(out: np.ndarray, seed: Word, stream: Word, first_block: int) -> None:
    """Fill ``out`` (length a multiple of 32) with the normals of whole blocks, one per period."""
    for block in range(out.size // BLOCK):
        for c in range(8):
            counter = np.uint64((first_block + block) * 8 + c)
            z = draw(seed, stream, counter)
            for m in range(4):
                out[block * BLOCK + m * 8 + c] = z[m]


fill_normals._cache = SourceCache(fill_normals.py_func, "normals")  # called from Python, too


def normals(seed: int, stream: int, start: int, stop: int) -> np.ndarray:
    """Return the standard normals of control periods ``start`` to ``stop`` (exclusive), shape (stop - start,)."""
    first = start // BLOCK
    out = np.empty((-(-stop // BLOCK) - first) * BLOCK)
    fill_normals(out, np.uint64(seed), np.uint64(stream), first)
    return out[start - first * BLOCK : stop - first * BLOCK]
