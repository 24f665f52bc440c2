"""The longest stretch of a recording in which nothing happens."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.noise import converter_step
from frictionloop.identification.onsets import quiet_noise
from frictionloop.quantities import must_be

Array = NDArray[np.float64]

LOUD = 2.0
"""A piece is quiet if its rms is below so many times that of the quietest quarter (assumed)."""
PIECE_S, SHORTEST_S = 0.1, 1.0


def given_stretch(interval_s: tuple[float, float], size: int, rate_hz: float) -> tuple[int, int]:
    """Return the rows of a stretch that is given in s."""
    first, stop = (round(end * rate_hz) for end in interval_s)
    if not (0 <= first < stop <= size and (stop - first) >= SHORTEST_S * rate_hz):
        raise must_be("interval_s", tuple(interval_s), f"1 s or more within 0 to {size / rate_hz:g}", "s")
    return first, stop


def quiet_stretch(reading: Array, rate_hz: float) -> tuple[int, int]:
    """Return the longest stretch of pieces that are as quiet as the quietest quarter."""
    length = max(round(PIECE_S * rate_hz), 8)
    pieces = reading.size // length
    if pieces * length < SHORTEST_S * rate_hz:
        raise must_be("recording: duration", reading.size / rate_hz, "1 or more", "s")
    cut = reading[: pieces * length].reshape(pieces, length)
    limit = LOUD * max(quiet_noise(reading), float(np.median(np.sort(cut.std(axis=1))[: max(pieces // 4, 1)])))
    limit = max(limit, converter_step(reading))  # a reading that hardly leaves one step is quiet
    calm = cut.std(axis=1) <= limit
    edges = np.flatnonzero(np.diff(np.concatenate([[0], calm.astype(np.int8), [0]]))).reshape(-1, 2)
    first, stop = max(edges.tolist(), key=lambda run: run[1] - run[0])
    if (stop - first) * length < SHORTEST_S * rate_hz:
        raise must_be("recording: longest quiet stretch", (stop - first) * length / rate_hz, "1 or more", "s")
    return first * length, stop * length
