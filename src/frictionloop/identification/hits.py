"""Hits in recordings: found by the noise and the last hit before them, each with a verdict and its reason."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.findings import Condition, Finding, shown
from frictionloop.identification.channel_summary import clipped
from frictionloop.identification.hit_onsets import (
    ABOVE_NOISE,
    BEFORE,
    blows_of,
    calm_rows,
    noise_of,
    piece_length,
    without_bow,
)
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, rate_of, samples_in
from frictionloop.identification.recording_file import Run, Stretches
from frictionloop.quantities import Array, FrictionloopError, must_be

LISTED = 3
"""Hits whose reasons stand in an error; the table has all."""

SMALL = 30.0
"""A hit whose peak is less than so many standard deviations of the noise tells little (assumed)."""
LEFT = 0.01
"""Share of a hit's peak that may be left before it, or at the end of its piece (assumed)."""
BOUNCE = 0.1
"""A second pulse above this share of the first makes a hit double (assumed)."""


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


def hits_left_out(found: Sequence[Hits], kept: Collection[str] = ("good",)) -> list[Finding]:
    """Return which hits of recordings were left out, by verdict."""
    by_verdict: dict[str, list[int]] = {}
    for each in found:
        for hit in each.table:
            if hit.verdict not in kept:
                by_verdict.setdefault(hit.verdict, []).append(hit.number)
    return [left_out_hits(numbers, why) for why, numbers in by_verdict.items()]


def left_out_hits(numbers: Sequence[int], why: str) -> Finding:
    """Return that some hits were left out."""
    where = Condition(channel=f"hits {shown(list(numbers))}")
    return Finding("LEFT-OUT", value=len(numbers), where=where, more={"reason": why})


def too_few(found: Sequence[Hits], good: int) -> FrictionloopError:
    """Return the error that too few hits are good, with what is wrong with the others."""
    reasons = [hit.reason for each in found for hit in each.table if hit.reason]
    listed = f": {'; '.join(dict.fromkeys(reasons[:LISTED]))}" if reasons else ""
    return must_be("recording: good hits", good, f"at least 2{listed}")


def pick_hits(
    recording: xr.Dataset,
    segment_s: float | None = None,
    exclude: Collection[int] = (),
    column: str | None = None,
    before: int | None = None,
) -> Hits:
    """Return every hit of a recording with a verdict.

    A hit begins where the channel leaves its median by ten standard deviations of its own noise, that of the quietest
    quarter of the recording, whichever way it goes, to a tenth of the last hit, and doubles what was there before. It
    is good unless it is clipped in any channel, followed by a second pulse, cut off by the end of the recording or of
    its piece, small, or begins while the last one still rings.

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
        samples_in("segment_s", segment_s, rate_hz, 16, reading.size, "the whole recording")
    away, bow = without_bow(signal)
    noise = noise_of(away, rate_hz)
    level = max(ABOVE_NOISE * noise, 1e-6 * float(np.max(np.abs(away))))
    blows = blows_of(away, level, calm_rows(away, rate_hz), rate_hz)
    onsets = [*blows]
    if not onsets:
        raise NoHits(str(must_be(f"recording: hits of {column!r}", 0, f"1 or more, above {level:.3g}")))
    still, under = (away, bow) if column == READING else without_bow(reading)
    length = piece_length(still, onsets, rate_hz) if segment_s is None else round(segment_s * rate_hz)
    ahead, earlier = int(BEFORE * length), before or 0
    flat = clipped(signal) | clipped(reading)
    for number in exclude:
        if before is None and not 1 <= number <= len(onsets):
            raise must_be("exclude", number, f"from 1 to {len(onsets)}")
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
            next_row=next((row - onset for row in (*blows[onset], *onsets[k + 1 : k + 2])), None),
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
        yield "small", f"small, {peak / noise:.0f} x noise"
    if of_hammer and (again := _bounce(np.abs(piece.pulse))) is not None:
        yield "double", f"double, bounces {1e3 * again / rate_hz:.1f} ms on"
    if piece.next_row is not None and piece.next_row < length - before:
        yield "double", f"double, {1e3 * piece.next_row / rate_hz:.0f} ms on"
    if piece.reading.size < length:
        yield "cut off", f"cut off at the {'start' if piece.before < before else 'end'}"
    largest = float(np.max(np.abs(piece.reading[piece.before :])))
    start, stop = (float(np.std(part)) for part in (piece.reading[: piece.before], piece.reading[-max(before, 2) :]))
    most = max(LEFT * largest, 3 * floor)
    if piece.before > 8 and start > most:
        yield "still ringing", f"still ringing, {100 * start / largest:.0f} % before it"
    if before > 8 and stop > most:
        yield "cut off", f"cut off, {100 * stop / largest:.0f} %"


def _bounce(pulse: Array) -> int | None:
    """Return the row of a second pulse above a tenth of the largest, after the force has fallen to a twentieth."""
    loud = pulse > BOUNCE * pulse.max()
    first = int(np.argmax(loud))
    fallen = np.flatnonzero(pulse[first:] < 0.5 * BOUNCE * pulse.max())
    if not fallen.size:
        return None
    again = np.flatnonzero(loud[first + fallen[0] :])
    return int(first + fallen[0] + again[0]) if again.size else None


def hits_of(
    recording: Run | Sequence[Run], segment_s: float | None = None, exclude: Collection[int] = ()
) -> Iterator[tuple[xr.Dataset, Hits]]:
    """Yield recordings with their hits, one after the other; those of several are numbered through.

    A part without hits is left out, unless there are none in any.
    """
    one = isinstance(recording, (xr.Dataset, Stretches)) or not isinstance(recording, Sequence)
    runs: list[Any] = [recording] if one else list(recording)
    if len(runs) == 1 and not isinstance(runs[0], Stretches):
        yield runs[0], pick_hits(runs[0], segment_s, exclude)
        return
    count, refused = 0, None
    for run in runs:
        for part in run if isinstance(run, Stretches) else [run]:
            try:
                found = pick_hits(part, segment_s, exclude, before=count)
            except FrictionloopError as error:
                if not isinstance(run, Stretches):
                    raise
                refused = error
                continue
            count += len(found.table)
            yield part, found
    if refused is not None and not count:
        raise refused
    unknown = [number for number in exclude if not 1 <= number <= count]
    if count and unknown:
        raise must_be("exclude", unknown[0], f"from 1 to {count}")
