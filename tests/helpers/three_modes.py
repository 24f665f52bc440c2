"""Hits on a plate with three modes, recorded at 100 kHz without a hammer channel."""

from __future__ import annotations

import numpy as np
import xarray as xr

RATE = 100e3
TRUE = ((1600.0, 40.0, 0.5), (3100.0, 60.0, 1.0), (4800.0, 50.0, 0.4))
"""Frequency in Hz, Q and amplitude of three modes, the second the strongest."""


def plate(seed=0, hits=6, noise=2e-3, spread=0.0, true=TRUE):
    draw = np.random.default_rng(seed)
    y = noise * draw.normal(size=int(hits * 0.1 * RATE))
    for k in range(hits):
        onset = int((0.1 * k + 0.02 + 0.01 * draw.random()) * RATE)
        time = np.arange(y.size - onset) / RATE
        for hertz, q, size in true:
            w = 2 * np.pi * hertz * (1 + spread * draw.normal())
            phase, scale = 2 * np.pi * draw.random(), size * draw.uniform(0.8, 1.2)
            y[onset:] += scale * np.exp(-w * time / (2 * q)) * np.sin(w * np.sqrt(1 - 0.25 / q**2) * time + phase)
    return xr.Dataset(
        {"f_m": ("time", y, {"units": "V"})}, {"time": ("time", np.arange(y.size) / RATE, {"units": "s"})}
    )
