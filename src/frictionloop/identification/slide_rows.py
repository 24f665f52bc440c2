"""Where a finger slides in a long record, the zeros of its channels, and what one slide tells of its friction."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.signal import butter, sosfiltfilt, welch
from scipy.stats import linregress

from frictionloop.identification.measured import Estimate
from frictionloop.identification.onsets import quiet_noise
from frictionloop.quantities import must_be

Array = NDArray[np.float64]
SMOOTH_S = 0.05
"""Time over which a position is turned into a speed, and a load is judged (assumed)."""
STEADY = 0.3
"""A finger slides where its speed is within this share of the median of the slide (assumed)."""
SLOWEST_M_S = 2e-3
SHORTEST_S = 0.3
LEAST_LOADS = 0.05
"""Relative spread of the load below which its exponent cannot be told (assumed)."""
BAND_HZ = (5.0, 100.0)
"""Band of the spectrum's slope: above the stroke, below the sensor."""
TREMOR_HZ = (6.0, 14.0)
"""Smith and others: a hand trembles at 8 to 12 Hz."""


def without_zero(values: Array, free: NDArray[np.bool_], margin: int) -> Array:
    """Return a channel less the line through the medians of the stretches without contact."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], free.astype(np.int8), [0]]))).reshape(-1, 2)
    inner = [(a + margin, b - margin) for a, b in edges.tolist() if b - a > 4 * margin]
    if not inner:
        return values
    centres = [(a + b) / 2 for a, b in inner]
    return np.asarray(values - np.interp(np.arange(values.size), centres, [np.median(values[a:b]) for a, b in inner]))


def slide_rows(touching: NDArray[np.bool_], speed: Array, rate_hz: float) -> list[tuple[int, int]]:
    """Return rows between which a finger touches and slides evenly."""
    least = max(SLOWEST_M_S, 5 * quiet_noise(speed))
    moving = touching & (np.abs(speed) > least)
    signed = np.where(moving, np.sign(speed), 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], signed, [0.0]])))
    runs = []
    for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        if signed[a] == 0 or (b - a) < SHORTEST_S * rate_hz:
            continue
        usual = float(np.median(np.abs(speed[a:b])))
        even = np.flatnonzero(np.abs(np.abs(speed[a:b]) - usual) < STEADY * usual)
        first, stop = a + int(even[0]), a + int(even[-1]) + 1
        if stop - first >= SHORTEST_S * rate_hz:
            runs.append((first, stop))
    return runs


def load_exponent(f: Array, n: Array, rate_hz: float) -> Estimate:
    """Return n of log f = c + n log N over means of a tenth of a second."""
    pieces = max(int(f.size / (0.1 * rate_hz)), 3)
    pairs = [
        (float(a.mean()), float(b.mean()))
        for a, b in zip(np.array_split(f, pieces), np.array_split(n, pieces), strict=True)
    ]
    good = np.array([pair for pair in pairs if min(pair) > 0])
    if len(good) < 3 or good[:, 1].std() < LEAST_LOADS * good[:, 1].mean():
        return Estimate(math.nan, math.inf, "", 1.0)
    line = linregress(np.log(good[:, 1]), np.log(good[:, 0]))
    return Estimate(float(line.slope), float(line.stderr), "", len(good) - 2.0)


def welch_slope(f: Array, rate_hz: float) -> float:
    """Return the exponent of the power spectrum by a line through Welch's, on logarithmic axes."""
    hertz, power = welch(f - f.mean(), rate_hz, nperseg=min(f.size, int(0.5 * rate_hz)), detrend="linear")
    inside = (hertz >= BAND_HZ[0]) & (hertz <= min(BAND_HZ[1], 0.4 * rate_hz))
    # Equal weight to each octave, as the eye gives a line on logarithmic axes.
    return float(np.polyfit(np.log(hertz[inside]), np.log(power[inside]), 1, w=1 / np.sqrt(hertz[inside]))[0])


def whittle_slope(f: Array, rate_hz: float) -> float:
    """Return the exponent p of S = c f^p that is likeliest for a periodogram I: least sum of log S + I/S."""
    size = f.size
    # A Hann window: a boxcar's leakage would hide slopes steeper than -2.
    window = np.hanning(size)
    line = np.polyval(np.polyfit(np.arange(size), f, 1), np.arange(size))
    power = np.abs(np.fft.rfft(window * (f - line))) ** 2
    hertz = np.fft.rfftfreq(size, 1 / rate_hz)
    inside = (hertz >= BAND_HZ[0]) & (hertz <= min(BAND_HZ[1], 0.4 * rate_hz))
    x, seen = hertz[inside], power[inside]

    def unlikely(p: float) -> float:
        shape = x**p
        return float(np.log(np.mean(seen / shape)) + np.mean(np.log(shape)))

    return float(minimize_scalar(unlikely, bounds=(-5, 2), method="bounded").x)


def tremor(f: Array, rate_hz: float) -> float:
    """Return the rms in N from 6 to 14 Hz."""
    sos = butter(2, TREMOR_HZ, "bandpass", fs=rate_hz, output="sos")
    return float(np.std(sosfiltfilt(sos, f - f.mean(), padlen=min(f.size - 1, int(0.3 * rate_hz)))))


def refuse_electroadhesion(recording: xr.Dataset, force: Array) -> None:
    """Refuse a recording whose friction rises with its ``amplitude``."""
    if "amplitude" not in recording:
        return
    amplitude = np.abs(np.asarray(recording["amplitude"].values, dtype=float))
    if np.ptp(amplitude) > 0 and float(np.corrcoef(amplitude, np.abs(force))[0, 1]) > 0.5:
        raise must_be("recording: friction", "rising with 'amplitude'", "falling: electroadhesion raises it")
