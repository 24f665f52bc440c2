"""How the friction of a slide falls off over frequency, and how much of it is tremor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.signal import butter, sosfiltfilt, welch

Array = NDArray[np.float64]

BAND_HZ = (5.0, 100.0)
"""Band of the spectrum's slope: above the stroke, below the sensor."""
TREMOR_HZ = (6.0, 14.0)
"""Smith and others: a hand trembles at 8 to 12 Hz."""


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
