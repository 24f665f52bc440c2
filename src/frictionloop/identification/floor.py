"""The floor of a spectrum: what the electronics add, free of the converter and of the pole."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.noise import NoiseSpectrum
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]

FILTERED = 1e-3
"""Share of the power density that is left near half the rate, below which a file was low-passed (assumed)."""


def density_of(
    spectrum: NoiseSpectrum,
    clean: NDArray[np.bool_],
    band_hz: tuple[float, float],
    cutoff_hz: float | None,
    step_n: float,
) -> Estimate:
    """Return the density of white noise before the pole, less the converter's, over a band without its lines."""
    hertz = spectrum.frequency_hz
    inside = clean & (hertz >= band_hz[0]) & (hertz <= band_hz[1])
    if np.count_nonzero(inside) < 4:
        raise FrictionloopError(f"recording: too short to tell its noise from {band_hz[0]:g} to {band_hz[1]:g} Hz")
    power = np.maximum(spectrum.power_density - step_n**2 / 6 / spectrum.rate_hz, 0.0)
    shape = _shape(spectrum, clean & (hertz >= band_hz[0]), power, cutoff_hz)
    white = power[inside] / shape[inside]
    mean = float(white.mean())
    # As band_rms: half overlapping Hann windows over the time that the recording lasts.
    width = white.size * float(hertz[1] - hertz[0])
    error = mean * math.sqrt(19 / 18 / (width * spectrum.duration_s))
    value = math.sqrt(mean)
    return Estimate(value, error / (2 * value) if value else 0.0, "N/rtHz")


def _shape(spectrum: NoiseSpectrum, inside: NDArray[np.bool_], power: Array, cutoff_hz: float | None) -> Array:
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
