"""Noise of the sensor left alone: spectrum, lines, rms, floor free of the converter; what printed figures imply."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.signal import get_window, welch

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.recording_columns import READING, channel, rate_of, runs_of, samples_in
from frictionloop.quantities import Array, must_be
from frictionloop.quantities.value_checks import ABOVE_0, number

OVERLAP_EXCESS = 19 / 18
"""Variance of a wide band's power by half overlapping Hann windows over the least possible: mean(g^2)/mean(g)^2 of the
weight g = 3/4 + cos(4 pi t/T)/4 that the samples get in all windows together."""
HANN_BINS = 1.5
"""Equivalent noise bandwidth of a Hann window in bins."""

FILTERED = 1e-3
"""Share of the power density that is left near half the rate, below which a file was low-passed (assumed)."""
SPUR = 10.0
"""A line is a spur if its power is above so many times the median around it (assumed)."""
AROUND = 101
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class NoiseSpectrum:
    """One-sided power density of the reading, by Welch's method."""

    frequency_hz: Array
    power_density: Array
    """unit^2/Hz."""
    averages: float
    """Effective number of independent pieces: the relative standard error of one frequency is 1/sqrt of it."""
    duration_s: float
    rate_hz: float
    unit: str

    @property
    def density(self) -> Array:
        """Amplitude density, unit/rtHz."""
        return np.asarray(np.sqrt(self.power_density))


def noise_spectrum(recording: xr.Dataset, segment_s: float = 1.0, column: str = READING) -> NoiseSpectrum:
    """Return the spectrum of a recording: Hann windows of ``segment_s``, overlapping by half, mean taken off each.

    Parameters
    ----------
    recording : xarray.Dataset
        The column, in N, over ``time`` in s. A reading in V or counts is to be calibrated first.
    segment_s : float
        Length of a window in s; 2/segment_s is about the resolution in Hz. At most half the recording.
    column : str
        Name of the column.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, or windows longer than half the recording.

    Notes
    -----
    Source: Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70, also for the number of averages.
    """
    values, rate_hz = channel(recording, column, ("N",)), rate_of(recording)
    length = samples_in("segment_s", segment_s, rate_hz, 16, values.size // 2, "half the recording")
    frequency, power = welch(values, rate_hz, window="hann", nperseg=length, noverlap=length // 2, detrend="constant")
    pieces = 1 + (values.size - length) // (length - length // 2)
    window = get_window("hann", length)
    shared = float(np.sum(window[length // 2 :] * window[: length - length // 2]) / np.sum(window**2)) ** 2
    averages = pieces / (1 + 2 * shared * (pieces - 1) / pieces)
    # The two lowest frequencies have lost power with the mean.
    return NoiseSpectrum(frequency[2:], power[2:], averages, values.size / rate_hz, rate_hz, "N")


def band_rms(spectrum: NoiseSpectrum, low_hz: float, high_hz: float) -> Estimate:
    """Return the standard deviation within a band in N: sqrt of the integral of S.

    Its standard error comes from var(integral) = (19/18) integral(S^2)/T, T the recording's length; S^2 is estimated
    without its own scatter.

    Parameters
    ----------
    spectrum : NoiseSpectrum
        From `noise_spectrum`.
    low_hz, high_hz : float
        Ends of the band in Hz, rising, with at least four frequencies in between.

    Raises
    ------
    FrictionloopError
        For a band that is empty or not within the spectrum.
    """
    inside = frequencies_inside(spectrum, low_hz, high_hz)
    step_hz = float(spectrum.frequency_hz[1] - spectrum.frequency_hz[0])
    power = spectrum.power_density[inside]
    total = float(np.sum(power)) * step_hz * (high_hz - low_hz) / (power.size * step_hz)
    squared = float(np.mean(power**2)) * (high_hz - low_hz) * spectrum.averages / (spectrum.averages + 1)
    if total == 0:
        return Estimate(0.0, 0.0, spectrum.unit)
    error = math.sqrt(OVERLAP_EXCESS * squared / spectrum.duration_s)
    return Estimate(math.sqrt(total), error / (2 * math.sqrt(total)), spectrum.unit)


def floor_density(spectrum: NoiseSpectrum, low_hz: float, high_hz: float) -> Estimate:
    """Return the amplitude density of the floor in N/rtHz: rms within a band where it is flat, over sqrt(its width).

    Parameters
    ----------
    spectrum : NoiseSpectrum
        From `noise_spectrum`.
    low_hz, high_hz : float
        Ends of the band in Hz; below the resonance, above slow drift.

    Raises
    ------
    FrictionloopError
        For a band that is empty or not within the spectrum.
    """
    rms = band_rms(spectrum, low_hz, high_hz)
    width = math.sqrt(high_hz - low_hz)
    return Estimate(rms.value / width, rms.standard_error / width, f"{spectrum.unit}/rtHz")


def frequencies_inside(spectrum: NoiseSpectrum, low_hz: float, high_hz: float) -> Mask:
    """Return which frequencies are within a band, refusing one that is empty or beyond the spectrum."""
    if not 0 <= low_hz < high_hz or high_hz > spectrum.rate_hz / 2:
        raise must_be("low_hz, high_hz", (low_hz, high_hz), f"rising within 0 to {spectrum.rate_hz / 2:g}", "Hz")
    inside = (spectrum.frequency_hz >= low_hz) & (spectrum.frequency_hz <= high_hz)
    if np.count_nonzero(inside) < 4:
        raise must_be("low_hz, high_hz", (low_hz, high_hz), "around 4 or more frequencies", "Hz")
    return inside


def density_of(
    spectrum: NoiseSpectrum, clean: Mask, band_hz: tuple[float, float], cutoff_hz: float | None, step_n: float
) -> Estimate:
    """Return the density of white noise before the pole, less the converter's, over a band without its lines."""
    hertz = spectrum.frequency_hz
    inside = clean & (hertz >= band_hz[0]) & (hertz <= band_hz[1])
    if np.count_nonzero(inside) < 4:
        said = f"recording: frequencies from {band_hz[0]:g} to {band_hz[1]:g} Hz"
        raise must_be(said, int(np.count_nonzero(inside)), "at least 4")
    power = np.maximum(spectrum.power_density - step_n**2 / 6 / spectrum.rate_hz, 0.0)
    shape = _shape(spectrum, clean & (hertz >= band_hz[0]), power, cutoff_hz)
    white = power[inside] / shape[inside]
    mean = float(white.mean())
    # As band_rms: half overlapping Hann windows over the time that the recording lasts.
    width = white.size * float(hertz[1] - hertz[0])
    error = mean * math.sqrt(19 / 18 / (width * spectrum.duration_s))
    value = math.sqrt(mean)
    return Estimate(value, error / (2 * value) if value else 0.0, "N/rtHz")


def _shape(spectrum: NoiseSpectrum, inside: Mask, power: Array, cutoff_hz: float | None) -> Array:
    """Return what the pole makes of white noise, plain or folded at half the rate, whichever the spectrum is nearer to.

        plain 1/(1 + (f/c)^2),   folded sum_k 1/(1 + ((f + k r)/c)^2) = (b/2) sinh b/(cosh b - cos(2 pi f/r))

    with b = 2 pi c/r: a recorder without a filter before its converter folds what lies above half its rate down.
    """
    hertz, rate_hz = spectrum.frequency_hz, spectrum.rate_hz
    if not cutoff_hz:
        return np.ones_like(hertz)
    b = 2 * math.pi * cutoff_hz / rate_hz
    plain = 1 / (1 + (hertz / cutoff_hz) ** 2)
    if b > 500:
        return plain  # nothing folds that the pole would have taken away
    folded = b / 2 * math.sinh(b) / (math.cosh(b) - np.cos(2 * math.pi * hertz / rate_hz))
    upto = inside & (hertz < 0.98 * rate_hz / 2) & (power > 0)
    misfit = [float(np.std(np.log(power[upto] / each[upto]))) for each in (plain, folded)]
    return plain if misfit[0] <= misfit[1] else np.asarray(folded)


def converter_step(force: Array) -> float:
    """Return the least step of the reading if its values are whole numbers of it."""
    levels = np.unique(force[:20000])
    if levels.size < 2 or levels.size > 5000:
        return 0.0
    gaps = np.diff(levels)
    step = float(gaps[gaps > 1e-6 * np.ptp(levels)].min()) if np.any(gaps > 1e-6 * np.ptp(levels)) else 0.0
    whole = step > 0 and bool(np.all(np.abs(gaps / step - np.rint(gaps / step)) < 0.01))
    return step if whole else 0.0


def low_passed(spectrum: NoiseSpectrum) -> bool:
    """Return whether the density near half the rate is a thousandth of that below: somebody has filtered."""
    half = spectrum.rate_hz / 2
    hertz, power = spectrum.frequency_hz, spectrum.power_density
    below, near = (hertz > 0.1 * half) & (hertz < 0.3 * half), hertz > 0.95 * half
    return float(np.median(power[near])) < FILTERED * float(np.median(power[below]))


class Spur(NamedTuple):
    """A line in the spectrum."""

    frequency_hz: float
    rms_n: float


def spurs_of(spectrum: NoiseSpectrum) -> tuple[list[Spur], Mask]:
    """Return the lines, the highest first, and which frequencies are free of them."""
    power = spectrum.power_density
    ground = median_filter(power, min(AROUND, power.size // 4 * 2 + 1), mode="nearest")
    high = power > SPUR * ground
    step_hz = float(spectrum.frequency_hz[1] - spectrum.frequency_hz[0])
    clean = np.ones(power.size, dtype=bool)
    found = []
    for first, stop in runs_of(high):
        shoulders = np.concatenate([power[max(first - 10, 0) : max(first - 3, 0)], power[stop + 3 : stop + 10]])
        if stop - first > 6 or power[first:stop].max() < SPUR / 2 * shoulders.max(initial=0.0):
            continue  # a hump, or part of one, not a line
        around = slice(max(first - 2, 0), stop + 2)
        clean[around] = False
        above = np.maximum(power[around] - ground[around], 0.0)
        excess = max(float(np.sum(power[around] - ground[around])) * step_hz, 0.0)
        hertz = float(np.sum(spectrum.frequency_hz[around] * above) / np.sum(above))
        found.append(Spur(hertz, math.sqrt(excess)))
    return sorted(found, key=lambda spur: -spur.rms_n), clean


def residual_share(r2: float) -> float:
    """Return the residual's standard deviation over that of the readings, sqrt(1 - R2); R2 = 0.95 gives 0.22.

    Raises ``FrictionloopError`` for an R2 outside 0 to 1.
    """
    return math.sqrt(1 - number("r2", r2, "", 0.0, 1.0))


def uniform_std_n(range_n: float = 2.5) -> float:
    """Return the standard deviation of loads spread evenly from 0 to the range, range/sqrt(12)."""
    return number("range_n", range_n, "N", ABOVE_0) / math.sqrt(12)


def dynamic_range_db(range_n: float, floor_n: float) -> float:
    """Return 20 log10(range/floor); 2.5 N over 5e-5 N is 93.98 dB. Raises ``FrictionloopError`` if not positive."""
    return 20 * math.log10(number("range_n", range_n, "N", ABOVE_0) / number("floor_n", floor_n, "N", ABOVE_0))


class FloorReading(NamedTuple):
    """A printed floor under one reading of the word."""

    density_n_rthz: float
    rms_n: float
    """Standard deviation behind the low-pass."""
    range_db: float
    """Range over that rms."""


def floor_readings(
    floor_n: float = 5e-5, cutoff_hz: float = 300.0, bin_hz: float = 0.1, range_n: float = 2.5
) -> dict[str, FloorReading]:
    """Return what a floor means as rms, as density and per bin of a spectrum, behind a first-order pole.

        rms = density sqrt(pi/2 cutoff),   per bin: density = floor/sqrt(bin * 1, or 1.5 with a Hann window)

    Parameters
    ----------
    floor_n : float
        The printed number, 5e-5 (paper, Sec. 3.3).
    cutoff_hz : float
        Low-pass in Hz, 300 (paper, Sec. 3.3).
    bin_hz : float
        Distance of frequencies in Hz; 0.1 for a sample of 10 s (paper, Sec. 3.3).
    range_n : float
        Largest force in N, 2.5 (paper, Sec. 3.1).

    Raises
    ------
    FrictionloopError
        For a number that is not positive.
    """
    floor = number("floor_n", floor_n, "N", ABOVE_0)
    width = math.sqrt(math.pi / 2 * number("cutoff_hz", cutoff_hz, "Hz", ABOVE_0))
    bin_ = number("bin_hz", bin_hz, "Hz", ABOVE_0)
    densities = {
        "rms": floor / width,
        "density": floor,
        "per bin": floor / math.sqrt(bin_),
        "per bin, Hann": floor / math.sqrt(HANN_BINS * bin_),
    }
    return {
        name: FloorReading(density, density * width, dynamic_range_db(range_n, density * width))
        for name, density in densities.items()
    }
