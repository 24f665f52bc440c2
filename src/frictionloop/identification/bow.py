"""A slow bow of a recording: what a charge amplifier, warmth or a hand adds beneath the hits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.onsets import quiet_noise

Array = NDArray[np.float64]
PIECES = 24
"""Pieces whose medians tell the bow: a ringing goes as far up as down, and leaves its median (assumed)."""
DEGREE = 5
"""Of the polynomial: two turns and a half in a record; a ringing has many more (assumed)."""
SHARE = 0.2
"""A bow is told where it leaves at most this share of what the medians scatter (assumed)."""
ABOVE_NOISE = 5.0
"""It spans at least so many standard deviations of the noise (assumed)."""
ROUNDS = 20
"""Rounds of reweighting towards least absolute deviations: pieces in which something happens do not count."""


def without_bow(values: Array) -> tuple[Array, float]:
    """Return a channel without its slow bow, and how much that spans; without its median, and 0, if there is none.

    The bow is a polynomial of fifth degree through the medians of 24 pieces, with the least absolute deviations.

    Parameters
    ----------
    values : array
        A recording, whole.
    """
    level = float(np.median(values))
    if values.size < 16 * PIECES:
        return values - level, 0.0
    size = values.size // PIECES
    medians = np.median(values[: size * PIECES].reshape(PIECES, size), axis=1)
    middle = 2 * ((np.arange(PIECES) + 0.5) * size - 0.5) / (values.size - 1) - 1
    columns = np.polynomial.legendre.legvander(middle, DEGREE)
    weight = np.ones(PIECES)
    share = np.zeros(DEGREE + 1)
    for _ in range(ROUNDS):
        share = np.asarray(np.linalg.lstsq(columns * weight[:, None], medians * weight, rcond=None)[0], dtype=float)
        off = np.abs(medians - columns @ share)
        weight = np.asarray(1 / np.sqrt(np.maximum(off, 1e-3 * np.ptp(medians) + 1e-300)), dtype=float)
    curve = np.polynomial.legendre.legval(np.linspace(-1, 1, values.size), share)
    span, left = float(np.ptp(curve)), float(np.median(np.abs(medians - columns @ share)))
    scatter = float(np.median(np.abs(medians - np.median(medians))))
    if span < ABOVE_NOISE * quiet_noise(values - curve) or left > SHARE * scatter:
        return values - level, 0.0
    return values - curve, span
