"""Statistics of one slide of a finger, the same for a recording and for a run: level, drift, spectrum, load.

Fluctuations are counted relative to the mean friction of the window, so that fingers of different friction compare.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.signal import detrend

from studies.slide_spectrum import band_rms, in_common, inside, power_law, waves_of
from studies.slide_window import window

BAND_HZ = (5.0, 100.0)
"""Band of the spectrum's slope: five waves a second and more fit a stroke; skin and sensors end well above 100 Hz."""
TREMOR_HZ = (8.0, 12.0)
"""Band of physiological tremor (Sutton & Sykes 1967)."""
FAST_HZ = (20.0, 100.0)
"""Band above tremor and voluntary movement."""
LOAD_HZ = (5.0, 20.0)
"""Band in which friction is compared with load: above slow drifts, below what load cells of this kind follow."""


class SlideStatistics(NamedTuple):
    """What `slide_statistics` gives."""

    friction_n: float
    """Mean friction F in N."""
    load_n: float
    """Mean load N in N."""
    coefficient: float
    """F / N."""
    spread: float
    """Standard deviation of the friction about its line, over F."""
    drift_per_s: float
    """Slope of that line over F, in 1/s."""
    slope: float
    """p of the spectrum S ~ f^-p over ``BAND_HZ``."""
    slope_error: float
    """Standard error of p; p +- 1.96 errors is the 95 % interval for Gaussian noise that follows the power law."""
    broad: float
    """Standard deviation within ``BAND_HZ``, over F."""
    tremor: float
    """Within ``TREMOR_HZ``, over F."""
    fast: float
    """Within ``FAST_HZ``, over F."""
    load_spread: float
    """Standard deviation of the load about its line, over N."""
    load_broad: float
    """Standard deviation of the load within ``BAND_HZ``, over N."""
    load_correlation: float
    """Correlation of friction and load within ``LOAD_HZ``, at no lag."""
    load_gain: float
    """Regression slope of friction on load within ``LOAD_HZ``, times N/F: a load exponent if nothing else varies."""
    own_slope: float
    """p of what the load did not do: of friction less regression slope times load, the latter up to ``LOAD_HZ[1]``."""
    own_broad: float
    """Standard deviation of the same within ``BAND_HZ``, over F."""


def slide_statistics(recording: xr.Dataset, start_s: float, stop_s: float, friction: str = "f_a") -> SlideStatistics:
    """Return level, drift and spectrum of the friction while a finger slides at constant speed.

    Bands and slope are those of one Hann periodogram of the window less its line; the slope is the one of largest
    likelihood (`slide_spectrum.power_law`).

    Parameters
    ----------
    recording : xarray.Dataset
        A run of ``simulate``, or a recording: friction and ``load`` in N over ``time`` in s, evenly sampled at 1 kHz
        or more. Friction is positive against the motion.
    start_s, stop_s : float
        Window in s, at least 0.8 s long.
    friction : str
        Column of the friction: ``f_a``, or ``f_m`` for what the sensor makes of it.
    """
    time, (f, n), rate_hz = window(recording, start_s, stop_s, {friction: "N", "load": "N"})
    mean_n, load_n = float(f.mean()), float(n.mean())
    line = np.polyfit(time - time.mean(), f, 1)
    frequency = np.fft.rfftfreq(f.size, 1.0 / rate_hz)
    waves, load_waves = waves_of(f), waves_of(n)
    correlation, gain = in_common(*(each[inside(frequency, LOAD_HZ)] for each in (waves, load_waves)))
    own = waves - np.where(inside(frequency, (0.0, LOAD_HZ[1])), gain * load_waves, 0.0)
    slope, error = power_law(friction, frequency, waves, BAND_HZ)
    return SlideStatistics(
        friction_n=mean_n,
        load_n=load_n,
        coefficient=mean_n / load_n,
        spread=float(detrend(f).std()) / mean_n,
        drift_per_s=float(line[0]) / mean_n,
        slope=slope,
        slope_error=error,
        broad=band_rms(frequency, waves, BAND_HZ) / mean_n,
        tremor=band_rms(frequency, waves, TREMOR_HZ) / mean_n,
        fast=band_rms(frequency, waves, FAST_HZ) / mean_n,
        load_spread=float(detrend(n).std()) / load_n,
        load_broad=band_rms(frequency, load_waves, BAND_HZ) / load_n,
        load_correlation=correlation,
        load_gain=gain * load_n / mean_n,
        own_slope=power_law(friction, frequency, own, BAND_HZ)[0],
        own_broad=band_rms(frequency, own, BAND_HZ) / mean_n,
    )
