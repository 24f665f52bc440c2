"""A finger that strokes a vibrating plate, by its equation: a recording whose every parameter is known."""

from __future__ import annotations

import numpy as np
import xarray as xr

RATE = 500.0
LARGEST = 2.4


def share_gaussian(a):
    return np.exp(-0.45 * a**2)


def share_exponential(a):
    return np.exp(-0.8 * a)


def share_threshold(a):
    return 1 - 0.4 * np.maximum(a - 0.8, 0)


def finger(share=share_gaussian, f0=1.1, n=0.9, growth=0.8, duration_s=60.0, seed=0, largest=LARGEST, scatter=0.03):
    """Friction f0 (N/0.5 N)^n (1 + g w) share(a) times a roughness that is a walk back to 1; strokes of 1.5 s."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(duration_s * RATE)) / RATE
    phase = (time / 1.5) % 2
    position = 0.03 * np.where(phase < 1, 2 * phase - 1, 3 - 2 * phase)
    load = 0.5 + 0.1 * np.sin(2 * np.pi * time / 7.3) + 0.05 * np.sin(2 * np.pi * time / 1.1)
    steps = np.concatenate([rng.permutation(8) for _ in range(20)])
    a = largest * np.sqrt(steps[(time / 0.7).astype(int)] / 7)
    kicks, rough, decay = rng.normal(size=time.size), np.zeros(time.size), np.exp(-1 / (0.1 * RATE))
    for k in range(1, time.size):
        rough[k] = decay * rough[k - 1] + np.sqrt(1 - decay**2) * kicks[k]
    wet = -np.expm1(-time / 20)
    friction = f0 * (load / 0.5) ** n * (1 + growth * wet) * share(a) * np.exp(scatter * rough)
    units = {"f_m": "N", "load": "N", "amplitude": "um", "position": "m"}
    signs = np.where(phase < 1, 1.0, -1.0)
    values = {"f_m": signs * friction, "load": load, "amplitude": a, "position": position}
    data = {name: ("time", each, {"units": units[name]}) for name, each in values.items()}
    return xr.Dataset(data, {"time": ("time", time, {"units": "s"})})
