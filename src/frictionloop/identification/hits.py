"""Hits in a recording: found by the noise before them, each with a verdict and its reason."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.bow import without_bow
from frictionloop.identification.channels import READING, READING_UNITS, channel, rate_of, samples_in
from frictionloop.identification.clipping import clipped
from frictionloop.identification.hit_faults import Piece, faults_of
from frictionloop.identification.onsets import ABOVE_NOISE, BEFORE, calm_rows, noise_of, onsets_of, piece_length
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
LISTED = 6
"""Reasons of so many hits are told one by one (assumed); the table has all."""


class NoHits(FrictionloopError):
    """A recording in which nothing is hit."""


class Hit(NamedTuple):
    """One hit."""

    number: int
    """From 1, in the order of the recording."""
    time_s: float
    peak: float
    """Largest deviation with its sign, in the unit of the channel in which the hits were found."""
    verdict: str
    """good, double, clipped, cut off, small, still ringing, excluded."""
    reason: str


@dataclass(frozen=True)
class Hits:
    """The hits of a recording, and where the good ones stand."""

    table: tuple[Hit, ...]
    channel: str
    """Channel in which they were found."""
    inverted: bool
    """Whether the pulses are negative."""
    starts: tuple[int, ...]
    """First rows of the pieces of the good hits."""
    before: int
    """Rows of a piece before its hit."""
    length: int
    """Rows of a piece."""
    noise: float
    """Standard deviation of the channel while nothing happens."""
    bow: float = 0.0
    """Span of the slow bow beneath the reading, which is taken off; 0 without one."""

    @property
    def good(self) -> int:
        """Number of good hits."""
        return len(self.starts)

    def told(self) -> str:
        """Return in words how many were used, and what was left out."""
        return told_of([self])


def told_of(found: Sequence[Hits]) -> str:
    """Return in words how many hits of recordings were used, and what was left out."""
    left_out = [hit for each in found for hit in each.table if hit.verdict != "good"]
    by_reason: dict[str, list[Hit]] = {}
    for hit in left_out:
        by_reason.setdefault(hit.reason if len(left_out) <= LISTED else hit.verdict, []).append(hit)
    left = [
        f"hit {hits[0].number} at {hits[0].time_s:.3f} s ({reason})"
        if len(hits) == 1
        else f"hits {', '.join(str(hit.number) for hit in hits)} ({reason})"
        for reason, hits in by_reason.items()
    ]
    good, every = sum(each.good for each in found), sum(len(each.table) for each in found)
    bows = [each.bow for each in found if each.bow]
    where = f" in {len(bows)} recordings" if len(found) > 1 else ""
    slow = f"; a slow bow of up to {max(bows):.3g} was taken off{where}" if bows else ""
    return f"{good} of {every} hits used" + (f"; left out: {', '.join(left)}" if left else "") + slow


def pick_hits(
    recording: xr.Dataset,
    segment_s: float | None = None,
    exclude: Collection[int] = (),
    column: str | None = None,
    before: int | None = None,
) -> Hits:
    """Return every hit of a recording with a verdict.

    A hit begins where the channel leaves its median by ten standard deviations of its own noise, that of the quietest
    quarter of the recording, whichever way it goes, and doubles what was there before. It is good unless it is clipped
    in any channel, followed by a second pulse, cut off by the end of the recording or of its piece, small, or begins
    while the last one still rings.

    Parameters
    ----------
    recording : xarray.Dataset
        Column ``f_m`` in N, V or counts over ``time`` in s, and ``hammer`` in N or V if there is one.
    segment_s : float, optional
        Length of a piece in s, a tenth of it before the hit. None: as long as the shortest time between hits allows,
        at most the time in which the response decays into its noise.
    exclude : collection of int
        Numbers of hits to leave out, as in the table.
    column : str, optional
        Channel in which to look; the hammer if there is one.
    before : int, optional
        Hits in earlier parts of the same recording: numbers go on from them.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, no hit at all, or a number to exclude that is none.
    """
    reading = channel(recording, READING, READING_UNITS)
    column = column or ("hammer" if "hammer" in recording else READING)
    units = ("N", "V", "counts") if column == "hammer" else READING_UNITS
    signal = reading if column == READING else channel(recording, column, units)
    rate_hz = rate_of(recording)
    if segment_s is not None:
        samples_in("segment_s", segment_s, rate_hz, 16, reading.size, "the length of the recording")
    away, bow = without_bow(signal)
    noise = noise_of(away, rate_hz)
    level = max(ABOVE_NOISE * noise, 1e-6 * float(np.max(np.abs(away))))
    onsets = onsets_of(away, level, calm_rows(away, rate_hz), column != READING)
    if not onsets:
        raise NoHits(
            f"recording: {column!r} has no hits: it never leaves its mean by {ABOVE_NOISE:g} times its noise "
            f"({noise:.3g}); accepted: a recording with hits"
        )
    still, under = (away, bow) if column == READING else without_bow(reading)
    length = piece_length(still, onsets, rate_hz) if segment_s is None else round(segment_s * rate_hz)
    ahead, earlier = int(BEFORE * length), before or 0
    flat = clipped(signal) | clipped(reading)
    for number in exclude:
        if before is None and not 1 <= number <= len(onsets):
            raise FrictionloopError(f"exclude = {number}: there is no such hit; accepted: 1 to {len(onsets)}")
    floor = noise_of(still, rate_hz)
    table: list[Hit] = []
    starts: list[int] = []
    for k, onset in enumerate(onsets):
        rows = slice(max(onset - ahead, 0), min(onset - ahead + length, signal.size))
        piece = Piece(
            pulse=away[onset : rows.stop],
            reading=still[rows],
            flat=int(np.count_nonzero(flat[rows])),
            before=onset - rows.start,
            wanted=(ahead, length),
            next_row=onsets[k + 1] - onset if k + 1 < len(onsets) else None,
        )
        peak = float(piece.pulse[np.argmax(np.abs(piece.pulse))])
        faults = faults_of(piece, noise, floor, rate_hz, column != READING)
        verdict, reason = next(faults, ("good", ""))
        if k + 1 + earlier in exclude:
            verdict, reason = "excluded", "excluded by hand"
        time_s = float(recording["time"][0]) + onset / rate_hz
        table.append(Hit(k + 1 + earlier, time_s, peak, verdict, reason))
        if verdict == "good":
            starts.append(onset - ahead)
    inverted = float(np.median([each.peak for each in table])) < 0
    return Hits(tuple(table), column, inverted, tuple(starts), ahead, length, noise, under)
