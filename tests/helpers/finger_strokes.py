"""Six strokes of a finger with known friction, load exponent, and the finger lifted before and after."""

from __future__ import annotations

import numpy as np
import xarray as xr

RATE = 2000.0


def coloured(draw, size, power):
    """Noise whose power falls as f^power, by its Fourier transform; unit variance."""
    hertz = np.fft.rfftfreq(size, 1 / RATE)
    hertz[0] = hertz[1]
    noise = np.fft.irfft(np.fft.rfft(draw.normal(size=size)) * hertz ** (power / 2), size)
    return noise / noise.std()


def strokes(seed=0, mu=0.6, exponent=0.8, drift=0.05, sign=1.0, share=0.03):
    """One second without contact, six strokes there and back under rising loads, and one more second."""
    draw = np.random.default_rng(seed)
    size = int(12 * RATE)
    time = np.arange(size) / RATE
    touching = (time > 2) & (time < 10)
    speed = np.where(touching, 0.04 * np.sign(np.sin(2 * np.pi * (time - 2) / 2.6667)), 0.0)
    load = np.where(touching, 0.3 + 0.06 * (time - 2) + 0.02 * np.sin(2 * np.pi * 0.9 * time), 0.0)
    level = mu * 0.5 * (np.maximum(load, 1e-9) / 0.5) ** exponent * (1 + share * coloured(draw, size, -1.4))
    zero = drift * time / 12
    force = sign * np.where(touching, level * np.sign(speed), 0.0) + zero + 1e-4 * draw.normal(size=size)
    return xr.Dataset(
        {
            "f_m": ("time", force, {"units": "N"}),
            "load": ("time", load + 0.1 + 1e-3 * draw.normal(size=size), {"units": "N"}),
            "position": ("time", np.cumsum(speed) / RATE, {"units": "m"}),
        },
        {"time": ("time", time, {"units": "s"})},
    )
