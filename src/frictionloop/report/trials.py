"""Synthetic sliding trials: one finger's friction law per trial, as in the paper's Fig. 1a."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.special import ndtr

from frictionloop.parameters import ColouredNoise, Friction
from frictionloop.physics.coloured_noise import colour, shaping_filter, stationary_state
from frictionloop.physics.fingers import LOG_NORMAL, UNIFORM
from frictionloop.physics.friction import friction_force
from frictionloop.quantities.normals import normals

Array = NDArray[np.float64]

CARRIER_UM = 2.5
"""Largest amplitude of the carrier (paper, Sec. 2.1)."""
MODULATION_HZ = 1.0
"""Frequency of the amplitude modulation (paper, Sec. 2.1)."""
LEVEL_SPREAD_N = 0.05
"""Standard deviation of a trial's constant part of d (assumed)."""
FLUCTUATION = ColouredNoise(rms_n=0.05, exponent=1.0, low_hz=0.5, high_hz=50.0)
"""Varying part of d relative to f0: 5 % rms (assumed), 1/f as the friction of a sliding finger (paper, ref. [18])."""
RATE_HZ, DURATION_S = 200.0, 2.0
PARAMETER_STREAM, FLUCTUATION_STREAM = 3, 4
"""Streams of the counter-based noise that no other part of the package draws from."""


def sliding_trials(n: int = 26, seed: int = 0) -> xr.Dataset:
    """Return synthetic sliding trials under an amplitude-modulated carrier, a population like that of Fig. 1a.

    f = f0 exp(-tau a^2) + d, equation (1), with a(t) = 1.25 um (1 - cos(2 pi 1 Hz t)) and, per trial, f0 uniform,
    tau log-normal, and d a constant plus 1/f noise. d is bounded below by -g(a), "so to avoid negative values of the
    friction force". Trial i is the same whatever ``n``.

    Returns
    -------
    xarray.Dataset
        ``a`` (um) over ``sample``; ``f`` and ``d`` (N) over both; ``f0`` (N) and ``tau`` (um^-2) over ``trial``.
    """
    samples = round(RATE_HZ * DURATION_S)
    time = np.arange(samples) / RATE_HZ
    a = CARRIER_UM / 2 * (1 - np.cos(2 * np.pi * MODULATION_HZ * time))
    f0, tau, level = _fingers(n, seed)
    g = np.array(
        [friction_force(a, Friction(nominal_n=f, susceptibility_per_um2=t)) for f, t in zip(f0, tau, strict=True)]
    )
    d = np.maximum(level[:, None] + f0[:, None] * _fluctuations(n, seed, samples), -g)
    both = ("trial", "sample")
    return xr.Dataset(
        {"a": ("sample", a), "f": (both, g + d), "d": (both, d), "f0": ("trial", f0), "tau": ("trial", tau)}
    )


def _fingers(n: int, seed: int) -> tuple[Array, Array, Array]:
    """Return f0 (N), tau (um^-2) and the constant part of d (N) of each trial, f0 and tau as of `fingers`."""
    z = normals(seed, PARAMETER_STREAM, 0, 3 * n).reshape(n, 3)
    (low, high), (median, spread) = UNIFORM["friction.nominal_n"], LOG_NORMAL["friction.susceptibility_per_um2"]
    f0 = low + (high - low) * ndtr(z[:, 0])
    return f0, median * np.exp(spread * z[:, 1]), LEVEL_SPREAD_N * z[:, 2]


def _fluctuations(n: int, seed: int, samples: int) -> Array:
    """Return 1/f noise relative to f0, shape (trials, samples)."""
    sos = shaping_filter(FLUCTUATION, RATE_HZ)
    lead = 2 * len(sos)
    drawn = normals(seed, FLUCTUATION_STREAM, 0, n * (lead + samples)).reshape(n, -1)
    noise, _ = colour(sos, drawn[:, lead:], stationary_state(sos, drawn[:, :lead]))
    return FLUCTUATION.rms_n * noise
