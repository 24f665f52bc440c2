"""Friction that varies from place to place: noise n(x) with a 1/kappa spectrum, fixed in space and periodic."""

from __future__ import annotations

import math

import numpy as np

from frictionloop.quantities.counter_noise import normals
from frictionloop.quantities.scalar_math import ROUND, bits, fma, step

ROUGHNESS_STREAM = 20
"""Stream of the counter-based noise that the table is drawn from."""
CELLS = 8192
"""Cells of the table; a power of two, which makes the wrap a mask."""
WAVES = CELLS // 8
"""Wavelengths from the longest to 1/1024 of it: with 8 cells or more to each, lines between cells are close enough."""


def roughness_table(rms: float, seed: int) -> np.ndarray:
    """Return one period of n(x), shape (CELLS,), to be joined by straight lines.

    n is Gaussian with E|n_k|^2 proportional to 1/k, k = 1 ... WAVES waves per period, and mean 0. It is then scaled so
    that the joined function has exactly the standard deviation asked for over a period, relative to the mean friction.
    It depends on nothing but the seed: 1/f background of a finger on a flat surface, Wiertlewski, Hudin, Hayward
    (springer 978-1-4471-4841-8_7); that it is fixed in space is assumed.
    """
    table, own_rms = roughness_shape(seed)
    return np.asarray(rms / own_rms * table)


def roughness_shape(seed: int) -> tuple[np.ndarray, float]:
    """Return n(x) before it is scaled, and its standard deviation, joined by straight lines."""
    drawn = normals(seed, ROUGHNESS_STREAM, 0, 2 * WAVES).reshape(WAVES, 2)
    spectrum = np.zeros(CELLS // 2 + 1, dtype=complex)
    spectrum[1 : WAVES + 1] = (drawn[:, 0] + 1j * drawn[:, 1]) / np.sqrt(np.arange(1.0, WAVES + 1.0))
    table = np.fft.irfft(spectrum, CELLS)
    # Mean square of a line from a to b: (a^2 + a b + b^2) / 3.
    mean_square = np.mean(2.0 * table * table + table * np.roll(table, -1)) / 3.0
    return table, math.sqrt(mean_square)


def cells_per_m(longest_mm: float) -> float:
    """Return how many cells of the table a metre holds, for its period in mm."""
    return CELLS / (1e-3 * longest_mm)


@step
def roughness_cells(position_m: float, per_m: float) -> tuple[int, int, float]:
    """Cell of the table at x, the next one, and how far x lies between them (0 to 1)."""
    cells = position_m * per_m
    shifted = (cells - 0.5) + ROUND
    cell = bits(shifted) & (CELLS - 1)
    return cell, (cell + 1) & (CELLS - 1), cells - (shifted - ROUND)


@step
def roughness_between(fraction: float, here: float, next_: float) -> float:
    """n(x) on the line between the values of two cells."""
    return fma(fraction, next_ - here, here)
