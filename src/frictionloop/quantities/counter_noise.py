"""Counter-based Gaussian noise: Philox4x32-10 and Box-Muller, a pure function of (seed, stream, period).

Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC'11 (doi 10.1145/2063384.2063405);
known answers from its Random123 library are tested. No state is carried, so any period of any lane can be drawn by any
thread, alone or in a grid, and is the same.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from frictionloop.quantities.compile_cache import keep_compiled
from frictionloop.quantities.scalar_math import SQRT_HALF, bits, double, fma, step

BLOCK = 32
"""Periods per block: one call to ``draw`` serves periods c, c+8, c+16 and c+24 of a block."""

Word = np.uint64
_MULTIPLIER_0, _MULTIPLIER_1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_WEYL_0, _WEYL_1 = np.uint64(0x9E3779B9), np.uint64(0xBB67AE85)
_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
# Doubles from 2^20 to 2^21 are 2^-32 apart: an integer added to the bits of one counts units of 2^-32.
_FIRST_BITS, _BEFORE_FIRST = 0x4130000000000000, 2.0**20 - 2.0**-33
_MIDDLE_BITS, _MIDDLE = 0x4138000000000000, 1.5 * 2.0**20
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
def minus_2_ln(x: float) -> float:
    """Return -2 ln x for 0 < x <= 1 with a relative error of 2e-13, without a division: noise needs many."""
    exponent = (bits(x) - SQRT_HALF) >> 52
    f = double(bits(x) - (exponent << 52)) - 1.0  # -2 ln(1 + f) = f P(f), -0.293 < f < 0.415
    f2 = f * f
    f4 = f2 * f2
    p0 = fma(fma(0.49999999901523484, f, -0.6666666665392852), f2, fma(1.0000000000023992, f, -2.0000000000001235))
    p1 = fma(fma(0.24999306141047503, f, -0.28571303535068826), f2, fma(0.3333334564645368, f, -0.4000000209708754))
    p2 = fma(fma(0.163626513639432, f, -0.18145575076020773), f2, fma(0.20020059808776303, f, -0.22225524456540352))
    p3 = fma(fma(0.07774322563246243, f, -0.15841368543849355), f2, fma(0.1649005130148568, f, -0.153990245659453))
    return fma(f, fma(fma(p3, f4, p2), f4 * f4, fma(p1, f4, p0)), float(exponent) * _MINUS_2_LN_2)


@step
def circle(word: Word) -> tuple[float, float]:
    """Return cos and sin of word / 2^32 turns, with errors below 6e-14."""
    quarter = (np.int64(word) + 0x20000000) >> 30  # the nearest quarter turn; the rest is within an eighth
    x = double(np.int64(word) - (quarter << 30) + _MIDDLE_BITS) - _MIDDLE
    z = x * x
    c = fma(fma(fma(-26.058123753882793, z, 60.23818359301454), z, -85.45676493719407), z, 64.93939383134831)
    c = fma(fma(c, z, -19.739208801922548), z, 0.9999999999999444)
    s = fma(fma(fma(-14.916565118819118, z, 42.05556925594499), z, -76.70583445845129), z, 81.60524918348393)
    s = fma(fma(s, z, -41.34170224027578), z, 6.28318530717956) * x
    turned = (quarter & 1) != 0
    c, s = s if turned else c, c if turned else s
    return double(bits(c) ^ (((quarter + 1) & 2) << 62)), double(bits(s) ^ ((quarter & 2) << 62))


@step
def box_muller(w0: Word, w1: Word) -> tuple[float, float]:
    """Return two independent standard normals from two 32-bit words, (w0 + 1/2) / 2^32 and w1 / 2^32; |z| < 6.8."""
    radius = math.sqrt(minus_2_ln(double(np.int64(w0) + _FIRST_BITS) - _BEFORE_FIRST))
    cosine, sine = circle(w1)
    return radius * cosine, radius * sine


@step
def draw_words(seed: Word, stream: Word, counter: Word) -> tuple[Word, Word, Word, Word]:
    """Return the four 32-bit words of a 64-bit seed, a stream number and a counter (uint64)."""
    return philox(counter & _LOW, counter >> _HALF, stream, np.uint64(0), seed & _LOW, seed >> _HALF)


@step
def draw(seed: Word, stream: Word, counter: Word) -> tuple[float, float, float, float]:
    """Return four standard normals for a 64-bit seed, a stream number and a counter (uint64)."""
    words = draw_words(seed, stream, counter)
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


# Called from Python, too.
keep_compiled(fill_normals, "normals")


def normals(seed: int, stream: int, start: int, stop: int) -> np.ndarray:
    """Return the standard normals of control periods ``start`` to ``stop`` (exclusive), shape (stop - start,)."""
    first = start // BLOCK
    out = np.empty((-(-stop // BLOCK) - first) * BLOCK)
    fill_normals(out, np.uint64(seed), np.uint64(stream), first)
    return out[start - first * BLOCK : stop - first * BLOCK]


def covariance_root(covariance: np.ndarray) -> np.ndarray:
    """Return the symmetric R with R R = ``covariance``, shape (n, n): it makes correlated normals of independent ones.

    Eigenvalues may be zero or, by rounding, just below. A factor V L^(1/2) would have the signs that a processor's
    library gives eigenvectors, so that one seed gave another noise on another machine.
    """
    powers, directions = np.linalg.eigh(covariance)
    return np.asarray(directions * np.sqrt(np.maximum(powers, 0.0)) @ directions.T)
