"""A quiet stretch of the sensor: density, counts, spurs, rms by band, and whether somebody has filtered it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from frictionloop.identification.channels import READING, READING_UNITS, channel, rate_of
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.hits import quiet_noise
from frictionloop.identification.noise import NoiseSpectrum, band_rms, noise_spectrum
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
LOUD = 2.0
"""A piece is quiet if its rms is below so many times that of the quietest quarter (assumed)."""
PIECE_S, SHORTEST_S = 0.1, 1.0
SPUR = 10.0
"""A line is a spur if its power is above so many times the median around it (assumed)."""
AROUND = 101
FILTERED = 1e-3
"""Share of the power density that is left near half the rate, below which a file was low-passed (assumed)."""
BANDS_HZ = (1.0, 10.0, 100.0, 1000.0, 10000.0)


class Spur(NamedTuple):
    """A line in the spectrum."""

    frequency_hz: float
    rms_n: float


@dataclass(frozen=True)
class Quiet:
    """What a sensor reads while nothing happens."""

    density: Estimate
    """Of the electronics before their low-pass, N/rtHz."""
    band_hz: tuple[float, float]
    """Band in which it was taken."""
    other_density_n_rthz: float
    """The same in the upper half of the band: how much the method matters."""
    rms_n: dict[str, float]
    """By band."""
    spurs: tuple[Spur, ...]
    step_n: float
    """Least step of the reading, the converter's, 0 if there is none."""
    filtered: bool
    interval_s: tuple[float, float]
    spectrum: NoiseSpectrum
    told: tuple[str, ...]


def noise(
    recording: xr.Dataset,
    interval_s: tuple[float, float] | None = None,
    sensitivity: float = 1.0,
    resonance_hz: float | None = None,
    cutoff_hz: float | None = None,
) -> Quiet:
    """Return the noise of a sensor from a recording in which nothing touches it.

    The density is that of the electronics: the mean power over a band that the vibration of the base does not reach,
    spurs left out, less the converter's step^2/12 over half the rate, over what the pole leaves of white noise. The
    band is from three times the resonance to twice the cutoff (the base is isolated there), or from 20 Hz where no
    resonance is told.

    Parameters
    ----------
    recording : xarray.Dataset
        Column ``f_m`` in N, V or counts over ``time`` in s.
    interval_s : tuple, optional
        From when to when it is quiet; None looks for the longest such stretch.
    sensitivity : float
        Unit of the reading per N, from `weights`.
    resonance_hz, cutoff_hz : float, optional
        Of the sensor, in Hz.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, or no second of quiet.
    """
    reading, rate_hz = channel(recording, READING, READING_UNITS) / sensitivity, rate_of(recording)
    first, stop = _stretch(reading, rate_hz) if interval_s is None else _given(interval_s, reading.size, rate_hz)
    force = reading[first:stop]
    time = xr.Variable("time", np.arange(force.size) / rate_hz, {"units": "s"})
    still = xr.Dataset({READING: ("time", force, {"units": "N"})}, {"time": time})
    spectrum = noise_spectrum(still, min(1.0, force.size / rate_hz / 8))
    spurs, clean = _spurs(spectrum)
    top = min(0.4 * rate_hz, 2 * cutoff_hz if cutoff_hz else math.inf)
    isolated = resonance_hz is not None and 4 * resonance_hz < top
    low = 3 * resonance_hz if isolated and resonance_hz else 20.0
    step = _step(force)
    density = _density(spectrum, clean, (low, top), cutoff_hz, step)
    upper = _density(spectrum, clean, (math.sqrt(low * top), top), cutoff_hz, step)
    filtered = _filtered(spectrum)
    told = [f"a line at {each.frequency_hz:.4g} Hz of {each.rms_n:.2g} N rms" for each in spurs[:5]]
    if not isolated:
        told.append(f"the density is that from {low:g} to {top:g} Hz, with whatever the base adds to the electronics")
    if filtered:
        told.append("the file was low-passed before it was saved: its density above is not the sensor's")
    if step and np.std(force) < 0.6 * step:
        told.append("the converter's step is coarser than the noise: the density is that of its steps")
    edges = [edge for edge in BANDS_HZ if edge < rate_hz / 2] + [rate_hz / 2]
    bands = [(a, b) for a, b in pairwise(edges) if _fits(spectrum, a, b)]
    rms = {f"{a:g} to {b:g} Hz": band_rms(spectrum, a, b).value for a, b in bands}
    return Quiet(
        density, (low, top), upper.value, rms, tuple(spurs), step, filtered,
        (first / rate_hz, stop / rate_hz), spectrum, tuple(told),
    )  # fmt: skip


def _fits(spectrum: NoiseSpectrum, low: float, high: float) -> bool:
    return int(np.count_nonzero((spectrum.frequency_hz >= low) & (spectrum.frequency_hz <= high))) >= 4


def _given(interval_s: tuple[float, float], size: int, rate_hz: float) -> tuple[int, int]:
    first, stop = (round(end * rate_hz) for end in interval_s)
    if not (0 <= first < stop <= size and (stop - first) >= SHORTEST_S * rate_hz):
        raise FrictionloopError(
            f"interval_s = {interval_s[0]:g} to {interval_s[1]:g} s: must be a second or more within 0 to "
            f"{size / rate_hz:g} s"
        )
    return first, stop


def _stretch(reading: Array, rate_hz: float) -> tuple[int, int]:
    """Return the longest stretch of pieces that are as quiet as the quietest quarter."""
    length = max(round(PIECE_S * rate_hz), 8)
    pieces = reading.size // length
    if pieces * length < SHORTEST_S * rate_hz:
        raise FrictionloopError(
            f"recording: it lasts {reading.size / rate_hz:.3g} s: must hold a second of quiet at least, better ten"
        )
    cut = reading[: pieces * length].reshape(pieces, length)
    limit = LOUD * max(quiet_noise(reading), float(np.median(np.sort(cut.std(axis=1))[: max(pieces // 4, 1)])))
    calm = cut.std(axis=1) <= limit
    edges = np.flatnonzero(np.diff(np.concatenate([[0], calm.astype(np.int8), [0]]))).reshape(-1, 2)
    first, stop = max(edges.tolist(), key=lambda run: run[1] - run[0])
    if (stop - first) * length < SHORTEST_S * rate_hz:
        raise FrictionloopError(
            f"recording: its longest quiet stretch is {(stop - first) * length / rate_hz:.2g} s: must be a second at "
            "least; interval_s names one"
        )
    return first * length, stop * length


def _spurs(spectrum: NoiseSpectrum) -> tuple[list[Spur], NDArray[np.bool_]]:
    """Return the lines, the highest first, and which frequencies are free of them."""
    power = spectrum.power_density
    ground = median_filter(power, min(AROUND, power.size // 4 * 2 + 1), mode="nearest")
    high = power > SPUR * ground
    step_hz = float(spectrum.frequency_hz[1] - spectrum.frequency_hz[0])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], high.astype(np.int8), [0]]))).reshape(-1, 2)
    clean = np.ones(power.size, dtype=bool)
    found = []
    for first, stop in edges.tolist():
        shoulders = np.concatenate([power[max(first - 10, 0) : max(first - 3, 0)], power[stop + 3 : stop + 10]])
        if stop - first > 6 or power[first:stop].max() < SPUR / 2 * shoulders.max(initial=0.0):
            continue  # a hump, or part of one, not a line
        around = slice(max(first - 2, 0), stop + 2)
        clean[around] = False
        at = first + int(np.argmax(power[first:stop]))
        excess = max(float(np.sum(power[around] - ground[around])) * step_hz, 0.0)
        found.append(Spur(float(spectrum.frequency_hz[at]), math.sqrt(excess)))
    return sorted(found, key=lambda spur: -spur.rms_n), clean


def _density(
    spectrum: NoiseSpectrum,
    clean: NDArray[np.bool_],
    band_hz: tuple[float, float],
    cutoff_hz: float | None,
    step_n: float,
) -> Estimate:
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


def _step(force: Array) -> float:
    """Return the least step of the reading if its values are whole numbers of it."""
    levels = np.unique(force[:20000])
    if levels.size < 2 or levels.size > 5000:
        return 0.0
    gaps = np.diff(levels)
    step = float(gaps[gaps > 1e-6 * np.ptp(levels)].min()) if np.any(gaps > 1e-6 * np.ptp(levels)) else 0.0
    whole = step > 0 and bool(np.all(np.abs(gaps / step - np.rint(gaps / step)) < 0.01))
    return step if whole else 0.0


def _filtered(spectrum: NoiseSpectrum) -> bool:
    half = spectrum.rate_hz / 2
    hertz, power = spectrum.frequency_hz, spectrum.power_density
    below, near = (hertz > 0.1 * half) & (hertz < 0.3 * half), hertz > 0.95 * half
    return float(np.median(power[near])) < FILTERED * float(np.median(power[below]))
