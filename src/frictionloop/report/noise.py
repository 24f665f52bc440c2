"""Fidelity and saturation against sensor noise, as in the paper's Fig. 2e and 2f, and what "noise level" may mean.

Sensor noise in the force and in the command with everything else held: equation (3) against the simulation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from frictionloop.analysis import command_noise_rms_n, equation_3_rms_n, kp_limit, linearise, output_noise_rms_n
from frictionloop.loop.simulate import simulate
from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System
from frictionloop.report.systems import held
from frictionloop.report.tolerances import R2_STEP

NOISE = "sensor.noise_rms_n"
LEVELS_N = np.geomspace(1e-6, 1.0, 49)
"""Standard deviation of the noise, N, one draw per control period; eight to the decade."""
SEEDS = 8
NO_STEP = 1e-6
"""Share of a step that is as good as none (chosen), as a power has no zero."""
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

    It is taken to move as a power of sigma between two points; None if it never moves that far.
    """
    median = metric.median("seed")
    moved = np.abs(median.values - median.values[0])
    beyond = np.flatnonzero(moved >= step)
    if beyond.size == 0:
        return None
    k = int(beyond[0])
    x = np.log(median["sigma"].values)
    y = np.log(np.maximum(moved[k - 1 : k + 1], step * NO_STEP))
    return math.exp(float(np.interp(math.log(step), y, x[k - 1 : k + 1])))


SIMULATED_KPS = (1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 18.0, 20.0, 40.0)
HELD_S, SCORED_S = 200.0, 40.0
"""The integral settles with (1 + Kp)/Ki, 10 s at most below the limit cycle; the rest is scored."""
TONE_HZ = 1.0
"""Where equation (3) is read as printed: the frequency of the disturbance (assumed)."""


def steady_noise(system: System) -> dict[str, float]:
    """Return the standard deviations of f_a and u (N) with set-point and disturbance held, from a simulation."""
    run = simulate(held(system), HELD_S)
    scored = run.isel(time=slice(-round(SCORED_S * system.controller.rate_hz), None))
    return {name: float(scored[name].std()) for name in ("f_a", "u")}


def noise_gain(system: System) -> xr.Dataset:
    """Return sigma_f / sigma_n and sigma_u / sigma_n over kp: simulated, exact, and by equation (3) at one frequency.

    ``simulated_f``, ``simulated_u`` lie over ``kp_simulated``; ``exact_f``, ``exact_u`` (discrete Lyapunov equation)
    and ``tone`` (|G/(1+G)| at 1 Hz) over ``kp``, up to ``kp_limit``.
    """
    limit = kp_limit(system)
    kps = np.geomspace(0.5, 0.999 * limit, 60)
    linear = [linear_gain(system.evolve({"controller.kp": kp})) for kp in kps]
    sigma = system.sensor.noise_rms_n
    simulated = [steady_noise(system.evolve({"controller.kp": kp})) for kp in SIMULATED_KPS]
    return xr.Dataset(
        {
            "exact_f": ("kp", [gain["f_a"] for gain in linear]),
            "exact_u": ("kp", [gain["u"] for gain in linear]),
            "tone": ("kp", [gain["tone"] for gain in linear]),
            "simulated_f": ("kp_simulated", [noise["f_a"] / sigma for noise in simulated]),
            "simulated_u": ("kp_simulated", [noise["u"] / sigma for noise in simulated]),
            "kp_limit": limit,
        },
        {"kp": kps, "kp_simulated": list(SIMULATED_KPS)},
    )


def linear_gain(system: System) -> dict[str, float]:
    """Return sigma_f / sigma_n, sigma_u / sigma_n and |G/(1+G)| at 1 Hz of the linear loop, N/N."""
    loop, sigma = linearise(held(system)), system.sensor.noise_rms_n
    tone = float(equation_3_rms_n(loop, [TONE_HZ])[0])
    return {
        "f_a": output_noise_rms_n(loop) / sigma,
        "u": command_noise_rms_n(loop) / sigma,
        "tone": tone / sigma,
    }
