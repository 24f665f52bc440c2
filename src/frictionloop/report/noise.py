"""Fidelity and saturation against sensor noise, as in the paper's Fig. 2e and 2f, and what "noise level" may mean."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System
from frictionloop.report.tolerances import R2_STEP

NOISE = "sensor.noise_rms_n"
LEVELS_N = np.geomspace(1e-6, 1.0, 49)
"""Standard deviation of the noise, N, one draw per control period; eight to the decade."""
SEEDS = 8
DURATION_S = 10.0
RATE_HZ = 5000.0
"""Rate of the draws (paper, Sec. 4.1)."""
BAND_HZ = RATE_HZ / 2
"""Band of a one-sided density: all that draws at this rate can hold."""


class NoiseReading(NamedTuple):
    """What a printed noise level of 10^-4 may be: its unit, and the standard deviation in N that it stands for."""

    unit: str
    sigma_n: Callable[[float], float]
    level: Callable[[float], float]


NOISE_READINGS: dict[str, NoiseReading] = {
    "rms": NoiseReading("N", lambda level: level, lambda sigma: sigma),
    "variance": NoiseReading("N²", math.sqrt, lambda sigma: sigma**2),
    "amplitude density": NoiseReading(
        "N/√Hz one-sided", lambda level: level * math.sqrt(BAND_HZ), lambda sigma: sigma / math.sqrt(BAND_HZ)
    ),
    "power density": NoiseReading(
        "N²/Hz one-sided", lambda level: math.sqrt(level * BAND_HZ), lambda sigma: sigma**2 / BAND_HZ
    ),
}
"""rms; variance (as random-number blocks ask for); densities, both one-sided over 0 to 2.5 kHz."""


def noise_sweep(system: System) -> xr.Dataset:
    """Return r2_identity and saturation_index over ``sigma`` (N) and ``seed``."""
    found = sweep(system, {NOISE: LEVELS_N}, DURATION_S, SEEDS, ["r2_identity", "saturation_index"], progress=False)
    return found.rename({NOISE: "sigma"})


def knee_n(metric: xr.DataArray, step: float = R2_STEP) -> float | None:
    """Return the noise (N rms) at which the median of a metric has moved by ``step`` from its value without noise.

    Interpolated over log sigma; None if it never moves that far.
    """
    median = metric.median("seed")
    moved = np.abs(median.values - median.values[0])
    beyond = np.flatnonzero(moved >= step)
    if beyond.size == 0:
        return None
    k = int(beyond[0])
    x = np.log(median["sigma"].values)
    return math.exp(float(np.interp(step, moved[k - 1 : k + 1], x[k - 1 : k + 1])))
