"""Slides of a finger in a long record: where they are, friction over load, how it falls off over frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.signal import butter, savgol_filter, sosfiltfilt, welch
from scipy.stats import linregress

from frictionloop.identification.channels import READING, channel, rate_of
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.hits import quiet_noise
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
SMOOTH_S = 0.05
"""Time over which a position is turned into a speed, and a load is judged (assumed)."""
STEADY = 0.3
"""A finger slides where its speed is within this share of the median of the slide (assumed)."""
SLOWEST_M_S = 2e-3
SHORTEST_S = 0.3
TOUCHING = 0.2
"""Share of the usual load above which a finger touches (assumed)."""
BAND_HZ = (5.0, 100.0)
"""Band of the spectrum's slope: above the stroke, below the sensor."""
TREMOR_HZ = (6.0, 14.0)
"""Smith and others: a hand trembles at 8 to 12 Hz."""

LIFTED = 0.4
"""A load that falls below this share of the usual one is that of a finger which has lifted (assumed)."""
LEAST_LOADS = 0.05
"""Relative spread of the load below which its exponent cannot be told (assumed)."""


class Slide(NamedTuple):
    """One slide."""

    start_s: float
    stop_s: float
    speed_m_s: float
    """With its sign."""
    friction_n: float
    """Mean, positive against the motion."""
    load_n: float
    mu: float
    mu_change: float
    """Of the last third over that of the first."""
    exponent: Estimate
    """n of friction ~ load^n within the slide; NaN where the load hardly changes."""
    slope_welch: float
    """Exponent of the power spectrum from 5 to 100 Hz, by a line through Welch's."""
    slope_whittle: float
    """The same by Whittle's likelihood of the periodogram."""
    tremor_n: float
    """rms of the friction from 6 to 14 Hz."""
    onset: float
    """Largest friction in the 0.2 s before the slide over its mean: stick before slip."""


@dataclass(frozen=True)
class Friction:
    """What slides tell of a finger."""

    slides: tuple[Slide, ...]
    mu: Estimate
    """Mean over slides; with two or more its error is their scatter."""
    exponent: Estimate
    """Of the load, over all slides."""
    told: tuple[str, ...]

    def level_n(self, load_n: float) -> float:
        """Return the friction at a load, mu N (load/N)^n about the mean load N of the slides, n = 1 if not known."""
        usual = float(np.mean([slide.load_n for slide in self.slides]))
        exponent = self.exponent.value if math.isfinite(self.exponent.value) else 1.0
        return self.mu.value * usual * (load_n / usual) ** exponent


def friction(recording: xr.Dataset) -> Friction:
    """Return friction from slides without vibration, found by speed and load.

    The zeros of friction and load are those of the stretches without contact, joined by straight lines.

    Parameters
    ----------
    recording : xarray.Dataset
        Columns ``f_m`` and ``load`` in N, and ``position`` in m or ``speed`` in m/s, over ``time`` in s.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, no slide, or friction that rises with an ``amplitude`` beside
        it, as electroadhesion does.
    """
    force, load, rate_hz = channel(recording, READING, ("N",)), channel(recording, "load", ("N",)), rate_of(recording)
    window = max(int(SMOOTH_S * rate_hz) // 2 * 2 + 1, 5)
    if "speed" in recording:
        speed = channel(recording, "speed", ("m/s",))
    else:
        position = channel(recording, "position", ("m",))
        speed = np.asarray(savgol_filter(position, window, 2, deriv=1, delta=1 / rate_hz))
    smooth = np.convolve(load - np.median(load), np.ones(window) / window, mode="same") + np.median(load)
    low, usual = float(np.percentile(smooth, 2)), float(np.percentile(smooth, 95))
    lifted = low < LIFTED * usual
    touching = smooth > low + TOUCHING * (usual - low) if lifted else np.ones(force.size, dtype=bool)
    if lifted:
        force, load = (_without_zero(each, ~touching, window) for each in (force, load))
    found = [_slide(force, load, speed, a, b, rate_hz) for a, b in _runs(touching, speed, rate_hz)]
    if not found:
        raise FrictionloopError(
            f"recording: no slide of {SHORTEST_S:g} s at an even speed above {1e3 * SLOWEST_M_S:g} mm/s in contact; "
            "accepted: position in m (or speed in m/s) and load in N of a finger that slides"
        )
    _refuse_electroadhesion(recording, force)
    mus = np.array([slide.mu for slide in found])
    scatter = float(mus.std(ddof=1) / math.sqrt(mus.size)) if mus.size > 1 else abs(found[0].mu_change - 1) * mus[0] / 3
    told = [f"slide of {s.stop_s - s.start_s:.2f} s at {1e3 * s.speed_m_s:.1f} mm/s: mu {s.mu:.3f}" for s in found]
    if not lifted:
        told.append("the finger never lifts: the zeros of friction and load are taken as they are")
    told += [f"mu changes by {s.mu_change - 1:+.0%} within a slide" for s in found if abs(s.mu_change - 1) > 0.1]
    return Friction(
        tuple(found), Estimate(float(mus.mean()), scatter, "", max(mus.size - 1.0, 1.0)), _exponent(found), tuple(told)
    )


def _without_zero(values: Array, free: NDArray[np.bool_], margin: int) -> Array:
    """Return a channel less the line through the medians of the stretches without contact."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], free.astype(np.int8), [0]]))).reshape(-1, 2)
    inner = [(a + margin, b - margin) for a, b in edges.tolist() if b - a > 4 * margin]
    if not inner:
        return values
    centres = [(a + b) / 2 for a, b in inner]
    return np.asarray(values - np.interp(np.arange(values.size), centres, [np.median(values[a:b]) for a, b in inner]))


def _runs(touching: NDArray[np.bool_], speed: Array, rate_hz: float) -> list[tuple[int, int]]:
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


def _slide(force: Array, load: Array, speed: Array, a: int, b: int, rate_hz: float) -> Slide:
    mean = float(force[a:b].mean())
    # Whichever way the sensor counts: friction opposes the motion, so its mean over a slide is positive.
    against = force * (1.0 if mean > 0 else -1.0)
    f, n = against[a:b], load[a:b]
    third = (b - a) // 3
    ratios = [float(f[part].mean() / n[part].mean()) for part in (slice(0, third), slice(-third, None))]
    before = against[max(a - int(0.2 * rate_hz), 0) : a]
    return Slide(
        start_s=a / rate_hz,
        stop_s=b / rate_hz,
        speed_m_s=float(speed[a:b].mean()),
        friction_n=float(f.mean()),
        load_n=float(n.mean()),
        mu=float(f.mean() / n.mean()),
        mu_change=ratios[1] / ratios[0],
        exponent=_load_exponent(f, n, rate_hz),
        slope_welch=_welch_slope(f, rate_hz),
        slope_whittle=_whittle_slope(f, rate_hz),
        tremor_n=_band(f, rate_hz),
        onset=float(before.max() / f.mean()) if before.size else math.nan,
    )


def _load_exponent(f: Array, n: Array, rate_hz: float) -> Estimate:
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


def _exponent(slides: Sequence[Slide]) -> Estimate:
    """Return the exponent over slides of different loads, or that within the slide with the least error."""
    loads = np.array([slide.load_n for slide in slides])
    if loads.size >= 4 and loads.std() > 0.1 * loads.mean():
        line = linregress(np.log(loads), np.log([slide.friction_n for slide in slides]))
        return Estimate(float(line.slope), float(line.stderr), "", loads.size - 2.0)
    return min((slide.exponent for slide in slides), key=lambda each: each.standard_error)


def _welch_slope(f: Array, rate_hz: float) -> float:
    hertz, power = welch(f - f.mean(), rate_hz, nperseg=min(f.size, int(0.5 * rate_hz)), detrend="linear")
    inside = (hertz >= BAND_HZ[0]) & (hertz <= min(BAND_HZ[1], 0.4 * rate_hz))
    # Equal weight to each octave, as the eye gives a line on logarithmic axes.
    return float(np.polyfit(np.log(hertz[inside]), np.log(power[inside]), 1, w=1 / np.sqrt(hertz[inside]))[0])


def _whittle_slope(f: Array, rate_hz: float) -> float:
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


def _band(f: Array, rate_hz: float) -> float:
    sos = butter(2, TREMOR_HZ, "bandpass", fs=rate_hz, output="sos")
    return float(np.std(sosfiltfilt(sos, f - f.mean(), padlen=min(f.size - 1, int(0.3 * rate_hz)))))


def _refuse_electroadhesion(recording: xr.Dataset, force: Array) -> None:
    if "amplitude" not in recording:
        return
    amplitude = np.abs(np.asarray(recording["amplitude"].values, dtype=float))
    if np.ptp(amplitude) > 0 and float(np.corrcoef(amplitude, np.abs(force))[0, 1]) > 0.5:
        raise FrictionloopError(
            "recording: friction rises with 'amplitude', as electroadhesion makes it: accepted are recordings of "
            "ultrasonic vibration, which lowers friction"
        )
