"""What is wrong with a hit, and why."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SMALL = 30.0
"""A hit whose peak is less than so many standard deviations of the noise tells little (assumed)."""
LEFT = 0.01
"""Share of a hit's peak that may be left before it, or at the end of its piece (assumed)."""
BOUNCE = 0.1
"""A second pulse above this share of the first makes a hit double (assumed)."""


class Piece(NamedTuple):
    """One hit and what surrounds it."""

    pulse: Array
    """Deviation of the channel in which the hit was found, from the hit to the end of the piece."""
    reading: Array
    """Deviation of the reading over the piece, as much of it as the recording holds."""
    flat: int
    """Samples that are clipped."""
    before: int
    """Rows before the hit, fewer than asked for at the start of the recording."""
    wanted: tuple[int, int]
    """Rows that there should be before the hit, and in all."""
    next_row: int | None
    """Rows to the hit that follows."""


def faults_of(piece: Piece, noise: float, floor: float, rate_hz: float, of_hammer: bool) -> Iterator[tuple[str, str]]:
    """Yield what is wrong with a hit, the worst first, and why."""
    peak, (before, length) = float(np.max(np.abs(piece.pulse))), piece.wanted
    if piece.flat:
        yield "clipped", f"clipped for {piece.flat} samples"
    if peak < SMALL * noise:
        yield "small", f"small, its peak is {peak / noise:.0f} times the noise"
    if piece.next_row is not None and piece.next_row < length - before:
        yield "double", f"double, another follows after {1e3 * piece.next_row / rate_hz:.0f} ms"
    if of_hammer and (again := _bounce(np.abs(piece.pulse))) is not None:
        yield "double", f"double, it bounces after {1e3 * again / rate_hz:.1f} ms"
    if piece.reading.size < length:
        yield "cut off", f"cut off by the {'start' if piece.before < before else 'end'} of the recording"
    largest = float(np.max(np.abs(piece.reading[piece.before :])))
    start, stop = (float(np.std(part)) for part in (piece.reading[: piece.before], piece.reading[-max(before, 2) :]))
    most = max(LEFT * largest, 3 * floor)
    if piece.before > 8 and start > most:
        yield "still ringing", f"still ringing, {100 * start / largest:.0f} % of its response before it"
    if before > 8 and stop > most:
        left = f"{100 * stop / largest:.0f} % of its response is left at the end of the piece"
        yield "cut off", f"cut off, {left}: segment_s must be longer"


def _bounce(pulse: Array) -> int | None:
    """Return the row of a second pulse above a tenth of the largest, after the force has fallen to a twentieth."""
    loud = pulse > BOUNCE * pulse.max()
    first = int(np.argmax(loud))
    fallen = np.flatnonzero(pulse[first:] < 0.5 * BOUNCE * pulse.max())
    if not fallen.size:
        return None
    again = np.flatnonzero(loud[first + fallen[0] :])
    return int(first + fallen[0] + again[0]) if again.size else None
