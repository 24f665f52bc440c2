"""Noise of the sensor left alone: spectrum, floor, rms in a band, corner of the low-pass."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.signal import get_window, welch

from frictionloop.identification.channels import READING, channel, rate_of
from frictionloop.identification.estimate import Estimate
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
_OVERLAP_EXCESS = 19 / 18
"""Variance of a wide band's power by half overlapping Hann windows over the least possible: mean(g^2)/mean(g)^2 of the
weight g = 3/4 + cos(4 pi t/T)/4 that the samples get in all windows together."""


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
    length = round(segment_s * rate_hz) if math.isfinite(segment_s) else 0
    if not 16 <= length <= values.size // 2:
        raise FrictionloopError(
            f"segment_s = {segment_s:g} s: must be from {16 / rate_hz:g} to {values.size // 2 / rate_hz:g}, "
            "half the recording"
        )
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
    inside = _inside(spectrum, low_hz, high_hz)
    step_hz = float(spectrum.frequency_hz[1] - spectrum.frequency_hz[0])
    power = spectrum.power_density[inside]
    total = float(np.sum(power)) * step_hz * (high_hz - low_hz) / (power.size * step_hz)
    squared = float(np.mean(power**2)) * (high_hz - low_hz) * spectrum.averages / (spectrum.averages + 1)
    if total == 0:
        return Estimate(0.0, 0.0, spectrum.unit)
    error = math.sqrt(_OVERLAP_EXCESS * squared / spectrum.duration_s)
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


@dataclass(frozen=True)
class FirstOrderNoise:
    """White noise behind a first-order low-pass, and the white noise of a converter."""

    density: Estimate
    """Before the low-pass, N/rtHz."""
    corner: Estimate
    """Cutoff of the low-pass in Hz."""
    white: Estimate
    """After it, N/rtHz."""


def fit_corner(spectrum: NoiseSpectrum, low_hz: float, high_hz: float) -> FirstOrderNoise:
    """Return density and corner of noise behind a first-order low-pass, as sampled.

        S(f) = s^2 (pi fc / rate) (1 - q^2)/(1 + q^2 - 2 q cos(2 pi f/rate)) + w^2,   q = e^(-2 pi fc/rate)

    is s^2/(1 + (f/fc)^2) with all that folds down from above half the rate, which at 5 kHz is not little. Whittle's
    likelihood, sum of log S + estimate/S, is made smallest; standard errors from its Fisher information.

    Parameters
    ----------
    spectrum : NoiseSpectrum
        From `noise_spectrum`.
    low_hz, high_hz : float
        Ends of the band in Hz. A resonance must be outside; the corner should be inside.

    Raises
    ------
    FrictionloopError
        For a band that is empty or not within the spectrum, or a spectrum without power in it.
    """
    inside = _inside(spectrum, low_hz, high_hz)
    frequency, power = spectrum.frequency_hz[inside], spectrum.power_density[inside]
    if not np.all(power > 0):
        raise FrictionloopError(
            "recording: there is no noise in the band; is the converter's step wider than the noise?"
        )
    rate = spectrum.rate_hz

    def shape(x: Array) -> Array:
        q = math.exp(-2 * math.pi * math.exp(x[1]) / rate)
        folded = (1 - q * q) / (1 + q * q - 2 * q * np.cos(2 * np.pi * frequency / rate))
        return np.asarray(math.exp(2 * x[0]) * math.pi * math.exp(x[1]) / rate * folded + math.exp(2 * x[2]))

    def slopes(x: Array) -> Array:
        """Return d log S/dx, by central differences of an exact formula."""
        small = 1e-5 * np.eye(3)
        return np.column_stack([(np.log(shape(x + d)) - np.log(shape(x - d))) / 2e-5 for d in small])

    def unlikeliness(x: Array) -> float:
        s = shape(x)
        return float(np.mean(np.log(s) + power / s))

    def gradient(x: Array) -> Array:
        return np.asarray(slopes(x).T @ (1 - power / shape(x)) / power.size)

    def curvature(x: Array) -> Array:
        """Return the expected second derivative, which is never negative: Fisher's information."""
        slope = slopes(x)
        return np.asarray(slope.T @ slope / power.size)

    ends = max(power.size // 20, 4)
    low_level, high_level = (math.log(float(np.mean(part))) / 2 for part in (power[:ends], power[-ends:]))
    corners = np.geomspace(2 * frequency[0], high_hz, 12)
    start = min((np.array([low_level, math.log(c), high_level - 1.0]) for c in corners), key=unlikeliness)
    options = {"gtol": 1e-9, "maxiter": 200}
    x = minimize(unlikeliness, start, jac=gradient, hess=curvature, method="trust-exact", options=options).x
    slope = slopes(x)
    # A band's scatter is 19/18/T per Hz: so much information does each frequency carry.
    step_hz = float(frequency[1] - frequency[0])
    information = slope.T @ slope * spectrum.duration_s * step_hz / _OVERLAP_EXCESS
    error = np.sqrt(np.diag(np.linalg.pinv(information)))
    values = np.exp(x)
    unit = f"{spectrum.unit}/rtHz"
    density, corner, white = (
        Estimate(float(v), float(v * e), u) for v, e, u in zip(values, error, (unit, "Hz", unit), strict=True)
    )
    return FirstOrderNoise(density, corner, white)


def _inside(spectrum: NoiseSpectrum, low_hz: float, high_hz: float) -> NDArray[np.bool_]:
    first, last = float(spectrum.frequency_hz[0]), float(spectrum.frequency_hz[-1])
    if not 0 <= low_hz < high_hz or high_hz > spectrum.rate_hz / 2:
        raise FrictionloopError(
            f"low_hz, high_hz = {low_hz:g}, {high_hz:g} Hz: must rise and be within 0 to {spectrum.rate_hz / 2:g}, "
            "half the rate of the recording"
        )
    inside = (spectrum.frequency_hz >= low_hz) & (spectrum.frequency_hz <= high_hz)
    if np.count_nonzero(inside) < 4:
        raise FrictionloopError(
            f"low_hz, high_hz = {low_hz:g}, {high_hz:g} Hz hold {np.count_nonzero(inside)} frequencies of {first:g} to "
            f"{last:g}: must hold at least four"
        )
    return inside
