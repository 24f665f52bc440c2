"""Hits in a recording: found by the noise before them, each with a verdict and its reason."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from frictionloop.identification.channels import READING, READING_UNITS, channel, rate_of, samples_in
from frictionloop.identification.preview import clipped
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
ABOVE_NOISE = 10.0
"""A hit begins where a channel leaves its mean by so many standard deviations of its noise (assumed: one false hit in
1e23 samples of normal noise; other noise has longer tails)."""
RISE = 2.0
"""A hit is at least so many times as large as what was there in two periods before (assumed)."""
SMALL = 30.0
"""A hit whose peak is less than so many standard deviations of the noise tells little (assumed)."""
LEFT = 0.01
"""Share of a hit's peak that may be left before it, or at the end of its piece (assumed)."""
BOUNCE = 0.1
"""A second pulse above this share of the first makes a hit double (assumed)."""
BEFORE = 0.1
"""Share of a piece that lies before its hit."""


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

    @property
    def good(self) -> int:
        """Number of good hits."""
        return len(self.starts)

    def told(self) -> str:
        """Return in words how many were used, and what was left out."""
        left = [
            f"hit {each.number} at {each.time_s:.3f} s ({each.reason})" for each in self.table if each.verdict != "good"
        ]
        return f"{self.good} of {len(self.table)} hits used" + (f"; left out: {', '.join(left)}" if left else "")


def pick_hits(
    recording: xr.Dataset, segment_s: float | None = None, exclude: Collection[int] = (), column: str | None = None
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
    away = signal - np.median(signal)
    noise = quiet_noise(away)
    level = max(ABOVE_NOISE * noise, 1e-6 * float(np.max(np.abs(away))))
    onsets = _onsets(away, level, _calm_rows(away, rate_hz), column != READING)
    if not onsets:
        raise FrictionloopError(
            f"recording: {column!r} has no hits: it never leaves its mean by {ABOVE_NOISE:g} times its noise "
            f"({noise:.3g}); accepted: a recording with hits"
        )
    still = reading - np.median(reading)
    length = _length(still, onsets, rate_hz) if segment_s is None else round(segment_s * rate_hz)
    before = int(BEFORE * length)
    flat = clipped(signal) | clipped(reading)
    for number in exclude:
        if not 1 <= number <= len(onsets):
            raise FrictionloopError(f"exclude = {number}: there is no such hit; accepted: 1 to {len(onsets)}")
    floor = quiet_noise(still)
    table: list[Hit] = []
    starts: list[int] = []
    for k, onset in enumerate(onsets):
        rows = slice(max(onset - before, 0), min(onset - before + length, signal.size))
        piece = _Piece(
            pulse=away[onset : rows.stop],
            reading=still[rows],
            flat=int(np.count_nonzero(flat[rows])),
            before=onset - rows.start,
            wanted=(before, length),
            next_row=onsets[k + 1] - onset if k + 1 < len(onsets) else None,
        )
        peak = float(piece.pulse[np.argmax(np.abs(piece.pulse))])
        faults = _faults(piece, noise, floor, rate_hz, column != READING)
        verdict, reason = next(faults, ("good", ""))
        if k + 1 in exclude:
            verdict, reason = "excluded", "excluded by hand"
        table.append(Hit(k + 1, onset / rate_hz, peak, verdict, reason))
        if verdict == "good":
            starts.append(onset - before)
    inverted = float(np.median([each.peak for each in table])) < 0
    return Hits(tuple(table), column, inverted, tuple(starts), before, length, noise)


def quiet_noise(values: Array) -> float:
    """Return the standard deviation of the quietest quarter of a signal, cut into up to 400 pieces."""
    pieces = min(400, max(values.size // 32, 1))
    cut = values[: values.size - values.size % pieces].reshape(pieces, -1)
    spread = np.sort(cut.std(axis=1))
    return float(np.median(spread[: max(pieces // 4, 1)]))


def _calm_rows(away: Array, rate_hz: float) -> int:
    """Return for how many rows a channel must have been calm before a hit: two periods of its strongest frequency."""
    spectrum = np.abs(np.fft.rfft(away - away.mean()))
    hertz = np.fft.rfftfreq(away.size, 1 / rate_hz)
    inside = hertz > 4 * rate_hz / away.size
    weight = spectrum[inside] ** 2
    # The median of the power: a pulse has no strongest frequency, a ringing has one.
    middle = float(hertz[inside][np.searchsorted(np.cumsum(weight), 0.5 * weight.sum())])
    return int(max(2 * rate_hz / max(middle, rate_hz / away.size), 16))


def _onsets(away: Array, level: float, calm: int, merged: bool) -> list[int]:
    """Return where a channel rises over the level, and to more than twice what it was in as many rows before.

    The tail of a ringing passes the level without such a rise. ``merged``: what follows within a fifth of the usual
    time between hits is a bounce of the same one.
    """
    size = np.abs(away)
    # maximum_filter1d looks from -calm//2 on: shifted, it is the largest of the rows ahead, and of those behind.
    ahead = maximum_filter1d(size, calm, origin=-(calm // 2) if calm % 2 else -(calm // 2) + 1)
    behind = np.concatenate([np.zeros(calm), ahead[:-calm]])
    risen = np.flatnonzero((ahead > level) & (ahead > RISE * behind))
    found: list[int] = []
    for first in risen[np.diff(risen, prepend=-(10**9)) > 1].tolist():
        onset = first + int(np.argmax(size[first:] > max(level, RISE * behind[first])))
        if not found or onset > found[-1] + calm:
            found.append(onset)
    if merged and len(found) > 2:
        apart = 0.2 * float(np.median(np.diff(found)))
        kept = found[:1]
        for onset in found[1:]:
            if onset - kept[-1] > apart:
                kept.append(onset)
        found = kept
    return found


def _length(still: Array, onsets: list[int], rate_hz: float) -> int:
    """Return the rows of a piece: until the strongest response has decayed, at most four fifths of the way on."""
    gaps = np.diff([*onsets, still.size])
    apart = [int(gap) for gap in gaps if gap > 0.2 * np.median(gaps)]
    most = int(0.8 * min(apart)) if apart else still.size
    floor = quiet_noise(still)
    top = max(onsets, key=lambda k: float(np.max(np.abs(still[k : k + most]))))
    envelope = maximum_filter1d(np.abs(still[top : top + most]), max(int(2e-3 * rate_hz), 8))
    loud = np.flatnonzero(envelope > max(5 * floor, 1e-3 * float(envelope.max())))
    decayed = int(loud[-1]) + 1 if loud.size else most
    return int(min(max(1.3 * decayed / (1 - BEFORE), 64), most / (1 - BEFORE)))


class _Piece(NamedTuple):
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


def _faults(piece: _Piece, noise: float, floor: float, rate_hz: float, of_hammer: bool) -> Iterator[tuple[str, str]]:
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
