"""A quiet stretch of the sensor: density, counts, spurs, rms by band, and whether somebody has filtered it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.identification.channels import READING, READING_UNITS, channel, rate_of
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.floor import converter_step, density_of, low_passed
from frictionloop.identification.noise import NoiseSpectrum, band_rms, noise_spectrum
from frictionloop.identification.quiet_stretch import given_stretch, quiet_stretch
from frictionloop.identification.spurs import Spur, spurs_of

Array = NDArray[np.float64]
BANDS_HZ = (1.0, 10.0, 100.0, 1000.0, 10000.0)


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
    began_s = float(recording["time"][0])
    first, stop = (
        quiet_stretch(reading, rate_hz)
        if interval_s is None
        else given_stretch((interval_s[0] - began_s, interval_s[1] - began_s), reading.size, rate_hz)
    )
    force = reading[first:stop]
    time = xr.Variable("time", np.arange(force.size) / rate_hz, {"units": "s"})
    still = xr.Dataset({READING: ("time", force, {"units": "N"})}, {"time": time})
    spectrum = noise_spectrum(still, min(1.0, force.size / rate_hz / 8))
    spurs, clean = spurs_of(spectrum)
    top = min(0.4 * rate_hz, 2 * cutoff_hz if cutoff_hz else math.inf)
    isolated = resonance_hz is not None and 4 * resonance_hz < top
    low = 3 * resonance_hz if isolated and resonance_hz else 20.0
    step = converter_step(force)
    density = density_of(spectrum, clean, (low, top), cutoff_hz, step)
    upper = density_of(spectrum, clean, (math.sqrt(low * top), top), cutoff_hz, step)
    filtered = low_passed(spectrum)
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
        (began_s + first / rate_hz, began_s + stop / rate_hz), spectrum, tuple(told),
    )  # fmt: skip


def _fits(spectrum: NoiseSpectrum, low: float, high: float) -> bool:
    return int(np.count_nonzero((spectrum.frequency_hz >= low) & (spectrum.frequency_hz <= high))) >= 4
