"""The index D of a spectrum or of a recorded residual, beside the filter of `perception.weighting`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline
from scipy.signal import welch

from frictionloop.parameters import Skin
from frictionloop.perception.detection_thresholds import HIGHEST_HZ, LOWEST_HZ, force_threshold_n
from frictionloop.quantities import Array, FrictionloopError
from frictionloop.quantities.value_checks import number, numbers

SEGMENT_S = 4.0
"""Length of a Welch segment: 0.25 Hz between frequencies, the Hann window is 1 Hz wide (zero to zero)."""
_POINTS_PER_DECADE = 400  # of F_th between the frequencies given: the integral then is good to 1e-5 (tested)

Band = tuple[float, float]


def index_of_spectrum(
    frequency_hz: ArrayLike, psd_n2_hz: ArrayLike, finger: Skin | None = None, band_hz: Band = (LOWEST_HZ, HIGHEST_HZ)
) -> Array:
    """Return D = sqrt(integral of S(f) / F_th(f)^2 df), an index of how strongly a residual force is felt.

    Energy summation over frequency, as the Pacinian channel (above 40 Hz) does; below 40 Hz it is a
    simplification (assumed, from memory). S holds mean squares and F_th is zero-to-peak, so a sine exactly at its
    threshold has D = 0.71 (-3 dB): well inside the +-6 dB of the thresholds.

    Parameters
    ----------
    frequency_hz
        Rising frequencies in Hz, shape (n,), covering the band.
    psd_n2_hz
        One-sided power density S of the residual in N^2/Hz, not negative, shape (..., n); linear in between.
    finger
        The fingertip; None is a `Skin` as it is.
    band_hz
        Limits of the integral, within 1 to 500 Hz. Over (40, 500) it is the share of the Pacinian channel.

    Raises
    ------
    FrictionloopError
        For frequencies that do not rise or do not cover the band, a negative density, shapes that do not fit.

    Notes
    -----
    Source: energy summation over frequencies (assumed, from memory); examples: test_perception_examples.py.
    """
    low, high = _band(band_hz)
    frequency = numbers("frequency_hz", frequency_hz, "Hz", 0.0)
    density = numbers("psd_n2_hz", psd_n2_hz, "N^2/Hz", 0.0)
    if frequency.ndim != 1 or frequency.size < 2 or np.any(np.diff(frequency) <= 0):
        raise FrictionloopError(f"frequency_hz has shape {frequency.shape}: must be at least two rising frequencies")
    if density.shape[-1:] != frequency.shape:
        raise FrictionloopError(f"psd_n2_hz has shape {density.shape}: must be (..., {frequency.size})")
    if frequency[0] > low or frequency[-1] < high:
        raise FrictionloopError(
            f"frequency_hz goes from {frequency[0]:g} to {frequency[-1]:g} Hz: must cover band_hz, {low:g} to {high:g}"
        )
    between = np.geomspace(low, high, math.ceil(_POINTS_PER_DECADE * math.log10(high / low)) + 2)
    between[0], between[-1] = low, high
    grid = np.union1d(frequency[(frequency > low) & (frequency < high)], between)
    weighted = make_interp_spline(frequency, density, k=1, axis=-1)(grid) / force_threshold_n(grid, finger) ** 2
    return np.asarray(np.sqrt(np.trapezoid(weighted, grid, axis=-1)))


def index_of_residual(
    residual_n: ArrayLike, rate_hz: float, finger: Skin | None = None, band_hz: Band = (LOWEST_HZ, HIGHEST_HZ)
) -> Array:
    """Return D of a recorded residual: `index_of_spectrum` of its Welch spectrum.

    Hann windows of 4 s, or of the whole record if that is shorter, overlapping by half; a straight line is taken
    out of each. Mean and slow drift therefore do not count. With records below 4 s
    the lower limit of the band blurs, since the window is 4 / duration wide.

    Parameters
    ----------
    residual_n
        Force residuals in N, for example f_a - f_r, shape (..., samples), at least 1 s long.
    rate_hz
        Sampling rate in Hz, at least twice the upper limit of the band.
    finger
        The fingertip; None is a `Skin` as it is.
    band_hz
        Limits of the integral, within 1 to 500 Hz.

    Raises
    ------
    FrictionloopError
        For a residual that is too short, no number or not finite, a rate too low, a band outside 1 to 500 Hz.
    """
    _, high = _band(band_hz)
    rate = number("rate_hz", rate_hz, "Hz", 2 * high)
    residual = numbers("residual_n", residual_n, "N")
    samples = residual.shape[-1] if residual.ndim else 0
    if samples < rate:
        raise FrictionloopError(f"residual_n lasts {samples / rate:g} s: must last at least 1 s")
    segment = min(samples, round(SEGMENT_S * rate))
    frequency, density = welch(residual, rate, window="hann", nperseg=segment, detrend="linear", axis=-1)
    # An odd number of samples has no bin at half the rate.
    frequency[-1] = max(frequency[-1], min(high, rate / 2))
    return index_of_spectrum(frequency, density, finger, band_hz)


def _band(band_hz: Band) -> Band:
    limits = numbers("band_hz", band_hz, "Hz", LOWEST_HZ, HIGHEST_HZ)
    if limits.shape != (2,) or limits[0] >= limits[1]:
        raise FrictionloopError(f"band_hz = {band_hz!r}: must be a lower and a higher frequency in Hz")
    return float(limits[0]), float(limits[1])
