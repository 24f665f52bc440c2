"""Where hits begin in a channel without its slow bow, and how long the piece around each may be."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import maximum_filter1d

from frictionloop.quantities import Array

ABOVE_NOISE = 10.0
"""A hit begins where a channel leaves its mean by so many standard deviations of its noise (assumed: one false hit in
1e23 samples of normal noise; other noise has longer tails)."""
OF_LAST = 0.1
"""A hit is at least this share of the last one's largest deviation (assumed): modes that beat come back with less."""
BOUNCE_S = 0.05
"""A hand does not hit twice within so many seconds (assumed)."""
RISE = 2.0
"""A hit is at least so many times as large as what was there in two periods before (assumed)."""
FIRST = 0.1
"""Share of the largest deviation at which the first hit is taken to have begun (assumed)."""
QUIET_S = 0.04
"""Two periods of the mains of 50 Hz: hum is part of what is there without a hit."""
LEAST_AHEAD = 64
"""Rows before the first hit from which a noise is taken (assumed)."""
LOOKED_AT = 200_000
"""Samples in which the steps of a converter are looked for."""
LEAST_LEVELS, MOST_LEVELS = 8, 4
"""A channel has steps of a converter where it takes more values than so many, each more often than so many times in the
mean (assumed)."""
BEFORE = 0.1
"""Share of a piece that lies before its hit."""
PIECES = 24
"""Pieces whose medians tell the bow: a ringing goes as far up as down, and leaves its median (assumed)."""
DEGREE = 5
"""Of the polynomial: two turns and a half in a record; a ringing has many more (assumed)."""
SHARE = 0.2
"""A bow is told where it leaves at most this share of what the medians scatter (assumed)."""
BOW_ABOVE = 5.0
"""It spans at least so many standard deviations of the noise (assumed)."""
ROUNDS = 20
"""Rounds of reweighting towards least absolute deviations: pieces in which something happens do not count."""


def quiet_noise(values: Array) -> float:
    """Return the standard deviation of the quietest quarter of a signal, cut into up to 400 pieces."""
    return _quietest(values, min(400, max(values.size // 32, 1)))


def _quietest(values: Array, pieces: int) -> float:
    cut = values[: values.size - values.size % pieces].reshape(pieces, -1)
    return float(np.median(np.sort(cut.std(axis=1))[: max(pieces // 4, 1)]))


def noise_of(values: Array, rate_hz: float) -> float:
    """Return the standard deviation of a channel while nothing happens, at least that of its converter's steps.

    It is that of the quietest 40 ms before the first tenth of the largest deviation, hum and all; where less than 64
    rows stand there, that of the quietest quarter of the recording.
    """
    size = np.abs(values)
    ahead = values[: int(0.9 * np.argmax(size > FIRST * size.max()))]
    least = _step(values) / np.sqrt(12)
    if ahead.size < LEAST_AHEAD:
        return float(max(quiet_noise(values), least))
    return float(max(_quietest(ahead, max(int(ahead.size / (QUIET_S * rate_hz)), 1)), least))


def _step(values: Array) -> float:
    """Return the step of a converter, 0 of a channel whose values hardly ever come twice."""
    some = values[:: max(values.size // LOOKED_AT, 1)]
    levels = np.unique(some)
    return float(np.diff(levels).min()) if LEAST_LEVELS < levels.size < some.size / MOST_LEVELS else 0.0


def calm_rows(away: Array, rate_hz: float) -> int:
    """Return for how many rows a channel must have been calm before a hit: two periods of its strongest frequency."""
    spectrum = np.abs(np.fft.rfft(away - away.mean()))
    hertz = np.fft.rfftfreq(away.size, 1 / rate_hz)
    inside = hertz > 4 * rate_hz / away.size
    weight = spectrum[inside] ** 2
    # The median of the power: a pulse has no strongest frequency, a ringing has one.
    middle = float(hertz[inside][np.searchsorted(np.cumsum(weight), 0.5 * weight.sum())])
    return int(max(2 * rate_hz / max(middle, rate_hz / away.size), 16))


def blows_of(away: Array, level: float, calm: int, rate_hz: float) -> dict[int, tuple[int, ...]]:
    """Return the rows at which hits begin, and of each those at which it bounces.

    A channel rises there over the level, a tenth of the last hit, and twice what was in as many rows before. The tail
    of a ringing passes the level without such a rise; modes that beat rise, but not to a tenth. What follows within 50
    ms, or a fifth of the usual time between hits, bounces.
    """
    size = np.abs(away)
    # maximum_filter1d looks from -calm//2 on: shifted, it is the largest of the rows ahead, and of those behind.
    ahead = maximum_filter1d(size, calm, origin=-(calm // 2) if calm % 2 else -(calm // 2) + 1)
    behind = np.concatenate([np.zeros(calm), ahead[:-calm]])
    risen = np.flatnonzero((ahead > level) & (ahead > RISE * behind))
    found: list[int] = []
    for rows in np.split(risen, np.flatnonzero(np.diff(risen) > 1) + 1) if risen.size else []:
        last = float(size[found[-1] : rows[0] + 1].max()) if found else 0.0
        if (large := rows[ahead[rows] > OF_LAST * last]).size:
            first = int(large[0])
            least = max(level, RISE * float(behind[first]), OF_LAST * last)
            onset = first + int(np.argmax(size[first:] > least))
            if not found or onset > found[-1] + calm:
                found.append(onset)
    apart = BOUNCE_S * rate_hz
    gaps = np.diff(found)
    apart = max(apart, 0.2 * float(np.median(gaps[gaps > apart]))) if np.any(gaps > apart) else apart
    blows: dict[int, tuple[int, ...]] = {}
    for onset in found:
        last = next(reversed(blows), -math.inf)
        if onset - last <= apart:
            blows[int(last)] += (onset,)
        else:
            blows[onset] = ()
    return blows


def piece_length(still: Array, onsets: list[int], rate_hz: float) -> int:
    """Return the rows of a piece: until the strongest response has decayed, at most four fifths of the way on."""
    gaps = np.diff([*onsets, still.size])
    apart = [int(gap) for gap in gaps if gap > 0.2 * np.median(gaps)]
    most = int(0.8 * min(apart)) if apart else still.size
    floor = noise_of(still, rate_hz)
    top = max(onsets, key=lambda k: float(np.max(np.abs(still[k : k + most]))))
    envelope = maximum_filter1d(np.abs(still[top : top + most]), max(int(2e-3 * rate_hz), 8))
    loud = np.flatnonzero(envelope > max(5 * floor, 1e-3 * float(envelope.max())))
    decayed = int(loud[-1]) + 1 if loud.size else most
    return int(min(max(1.3 * decayed / (1 - BEFORE), 64), most / (1 - BEFORE)))


def without_bow(values: Array) -> tuple[Array, float]:
    """Return a channel without its slow bow, and how much that spans; without its median, and 0, if there is none.

    The bow is a polynomial of fifth degree through the medians of 24 pieces, with the least absolute deviations.
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
    if span < BOW_ABOVE * quiet_noise(values - curve) or left > SHARE * scatter:
        return values - level, 0.0
    return values - curve, span
