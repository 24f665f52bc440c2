"""What follows the good hits of recordings: free decays, as long as they are heard, as slow as they allow."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.signal import decimate

from frictionloop.findings import Finding
from frictionloop.identification.hits import Hits, hits_left_out, hits_of, too_few
from frictionloop.identification.long import Run
from frictionloop.identification.onsets import noise_of, without_bow
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, rate_of
from frictionloop.quantities import must_be

Array = NDArray[np.float64]

PULSE = 0.02
"""Share of its peak below which a hammer's force has ended (assumed)."""
ABOVE_HAMMER = 8.0
"""Standard deviations of the hammer's noise that count as force; quiet times tell the noise somewhat low (assumed)."""
LONGEST = 2000
"""Samples of a decay that are fitted; a longer one is decimated as its frequencies allow."""


class Decays(NamedTuple):
    """What follows the hits of recordings."""

    pieces: list[Array]
    rate_hz: float
    picked: list[Hits]
    cut: int
    """How many of them are of hits that are cut off."""

    def findings(self) -> list[Finding]:
        """Return which hits were left out."""
        return hits_left_out(self.picked, ("good", "cut off") if self.cut else ("good",))


def decays_of(runs: Run | Sequence[Run], segment_s: float | None, exclude: Collection[int]) -> Decays:
    """Return what follows each good hit, from after its peak until it is lost in the noise.

    With fewer than two good hits those that are cut off are used as well: a free decay need not come to its end.
    """
    decays: list[Array] = []
    cut: list[Array] = []
    picked, rates = [], set()
    for run, found in hits_of(runs, segment_s, exclude):
        reading, rate_hz = without_bow(channel(run, READING, READING_UNITS))[0], rate_of(run)
        picked.append(found)
        rates.add(rate_hz)
        force = run["hammer"].values if found.channel == "hammer" else None
        floor = noise_of(reading, rate_hz)
        for hit in found.table:
            onset = round((hit.time_s - float(run["time"][0])) * rate_hz)
            if hit.verdict in ("good", "cut off"):
                decay = _decay(reading, force, onset, found, floor)
                (decays if hit.verdict == "good" else cut).extend([decay] if decay.size >= 32 else [])
    if len(rates) > 1:
        raise must_be("recording: rates", sorted(rates), "one", "Hz")
    used = cut if len(decays) < 2 <= len(decays) + len(cut) else []
    if len(decays) + len(used) < 2:
        raise too_few(picked, len(decays))
    return Decays(decays + used, rates.pop(), picked, len(used))


def _decay(reading: Array, force: Array | None, onset: int, found: Hits, floor: float) -> Array:
    """Return what follows one hit."""
    start, stop = max(onset - found.before, 0), onset - found.before + found.length
    ahead = reading[start : max(onset - 2, start + 1)]
    piece = reading[start:stop] - (ahead.mean() if ahead.size > 8 else np.median(reading[start:stop]))
    begin = onset - start
    return _audible(piece[begin + _end_of_pulse(force, start, begin, stop - start, found.noise) :], floor)


def _end_of_pulse(force: Array | None, start: int, before: int, length: int, noise: float) -> int:
    """Return how many rows after a hit its force is last seen, above a fiftieth of its peak and above its noise."""
    if force is None:
        return 0
    pulse = np.abs(force[start + before : start + length] - np.median(force))
    return int(np.flatnonzero(pulse > max(PULSE * pulse.max(), ABOVE_HAMMER * noise))[-1]) + 2


def _audible(decay: Array, floor: float) -> Array:
    """Return a decay from its largest value to where it is lost in the noise."""
    top = int(np.argmax(np.abs(decay)))
    envelope = maximum_filter1d(np.abs(decay[top:]), max(int(decay.size / 50), 8))
    over = np.flatnonzero(envelope > max(4 * floor, 5e-3 * float(envelope.max())))
    # A copy: a view would keep the whole piece of each hit in the memory.
    return decay[top : top + int(over[-1]) + 1].copy() if over.size else decay[top:top]


def slower(decays: list[Array], rate_hz: float) -> tuple[list[Array], float]:
    """Decimate long decays as far as what they contain allows; a filter keeps poles where they are."""
    longest = max(decay.size for decay in decays)
    spectrum = np.zeros(longest // 2 + 1)
    for decay in decays:
        spectrum += np.abs(np.fft.rfft(decay - decay.mean(), longest)) ** 2
    hertz = np.fft.rfftfreq(longest, 1 / rate_hz)
    top_hz = float(hertz[np.searchsorted(np.cumsum(spectrum), 0.999 * spectrum.sum())])
    factor = min(int(rate_hz / (5 * top_hz)), max(longest // LONGEST, 1) * 4, 12)
    if factor > 1 and longest > 1000:
        decays = [decimate(decay, factor, ftype="fir")[12:] for decay in decays]
        rate_hz /= factor
    return [decay[:LONGEST] for decay in decays], rate_hz
