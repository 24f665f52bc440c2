"""Resonance and Q of the sensor from how it rings after taps: for a bench without an impact hammer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.optimize import least_squares

from frictionloop.identification.measured import Estimate
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, pieces, rate_of, samples_in
from frictionloop.identification.refused import Refused
from frictionloop.quantities import must_be

Array = NDArray[np.float64]
TRIGGER = 0.3
"""A tap is where the reading passes this share of the largest."""
FROM, TO = 0.5, 0.05
"""Shares of a tap's largest reading between which its ringing counts: before, what taps may still touch."""
LEAST_TAPS, LEAST_PERIODS = 3, 4.0
WORST_MISFIT = 0.2
"""Most of the rms of a decay that one damped oscillation may leave unexplained (assumed)."""


@dataclass(frozen=True)
class RingDown:
    """The suspension, as it rings by itself."""

    resonance: Estimate
    """Hz, undamped."""
    q: Estimate
    taps: int
    misfit: float
    """rms of what a damped oscillation leaves over that of the decay, the worst tap's."""


def fit_ring_down(recording: xr.Dataset, between_s: float = 0.5) -> RingDown:
    """Return resonance and Q with their uncertainties from a sensor that was tapped and rang.

        y(t) = c + e^(-w t/(2 Q)) (a cos(w_d t) + b sin(w_d t)),   w_d = w sqrt(1 - 1/(4 Q^2))

    by least squares for every tap; the estimate is the mean over taps, and their scatter its standard error, whatever
    it is that scatters. What follows the springs (a pole far above the resonance) changes a and b alone. How hard the
    taps are is not asked; no finger may rest on the glass.

    Parameters
    ----------
    recording : xarray.Dataset
        Column ``f_m`` in N, V or counts, over ``time`` in s, with at least three taps.
    between_s : float
        Time in s after a tap in which there is no other: the ringing must be over.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, too few taps, a rate too low, or a reading that does not ring
        as one resonance does; then ``fl.plot(error)`` draws the tap.
    """
    reading, rate_hz = channel(recording, READING, READING_UNITS), rate_of(recording)
    length = samples_in("between_s", between_s, rate_hz, 32, reading.size, "the whole recording")
    still = np.abs(reading - np.median(reading))
    starts = pieces(still > TRIGGER * still.max(), length)
    if len(starts) < LEAST_TAPS:
        raise must_be(f"recording: taps with {between_s:g} s after each", len(starts), f"at least {LEAST_TAPS}")
    found = np.array([_fit(reading[k : k + length] - np.median(reading), rate_hz) for k in starts])
    mean, scatter = found.mean(axis=0), found.std(axis=0, ddof=1) / math.sqrt(len(found))
    hertz, q = (
        Estimate(float(value), float(error), unit, len(found) - 1.0)
        for value, error, unit in zip(mean[:2], scatter[:2], ("Hz", ""), strict=True)
    )
    return RingDown(hertz, q, len(found), float(found[:, 2].max()))


def _fit(piece: Array, rate_hz: float) -> tuple[float, float, float]:
    """Return resonance in Hz, Q and misfit of one tap."""
    spectrum = np.abs(np.fft.rfft(piece - piece.mean()))
    around_hz = float(np.fft.rfftfreq(piece.size, 1.0 / rate_hz)[1 + int(np.argmax(spectrum[1:]))])
    if around_hz > 0.25 * rate_hz:
        raise must_be("recording: rate", rate_hz, f"at least {4 * around_hz:g}, four times the ringing", "Hz")
    envelope = maximum_filter1d(np.abs(piece - np.median(piece)), max(round(rate_hz / around_hz), 3))
    top = int(np.argmax(envelope))
    below = [top + int(np.argmax(envelope[top:] < share * envelope[top])) for share in (FROM, TO)]
    begin, end = below[0], below[1] if below[1] > top else piece.size
    if begin <= top or (end - begin) * around_hz < LEAST_PERIODS * rate_hz:
        seen = {"time_s": (np.arange(piece.size) / rate_hz).tolist(), "reading": piece.tolist()}
        periods = (end - begin) * around_hz / rate_hz
        said = f"recording: periods of a tap at {around_hz:.4g} Hz = {periods:.2g}: must be {LEAST_PERIODS:g} or more"
        raise Refused(said, "hits", {"decay": seen})
    time, decay = np.arange(end - begin) / rate_hz, piece[begin:end]
    curves = {"decay": {"time_s": time.tolist(), "reading": decay.tolist()}}

    def left(x: Array) -> Array:
        shape = damped(time, [(float(np.exp(x[0])), float(np.exp(x[1])))])
        return np.asarray(shape @ np.linalg.lstsq(shape, decay, rcond=None)[0] - decay)

    guess_q = math.pi * around_hz * (end - begin) / rate_hz / math.log(FROM / TO)
    fit = least_squares(left, np.log([around_hz, max(guess_q, 1.0)]), x_scale=[1e-3, 1e-2], xtol=1e-12, ftol=1e-12)
    misfit = float(np.linalg.norm(fit.fun) / np.linalg.norm(decay - decay.mean()))
    if not fit.success or misfit > WORST_MISFIT:
        said = f"recording: misfit of a damped oscillation = {misfit:.2g}: must be at most {WORST_MISFIT:g}"
        raise Refused(said, "hits", curves)
    return float(np.exp(fit.x[0])), float(np.exp(fit.x[1])), misfit


def damped(time_s: Array, modes: Sequence[tuple[float, float]]) -> Array:
    """Return a constant and the two phases of each damped oscillation (Hz, Q), shape (time, 1 + 2 modes)."""
    columns = [np.ones_like(time_s)]
    for resonance_hz, q in modes:
        angle = 2.0 * math.pi * resonance_hz * time_s
        turns = angle * math.sqrt(max(1.0 - 0.25 / q**2, 1e-6))
        falls = np.exp(-0.5 * angle / q)
        columns += [falls * np.cos(turns), falls * np.sin(turns)]
    return np.stack(columns, axis=1)
