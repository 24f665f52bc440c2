"""Sensor noise in the force and in the command with everything else held: equation (3) against the simulation."""

from __future__ import annotations

import numpy as np
import xarray as xr

from frictionloop.analysis import command_noise_rms_n, equation_3_rms_n, kp_limit, linearise, output_noise_rms_n
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import System
from frictionloop.report.systems import held

SIMULATED_KPS = (1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 14.0, 18.0, 20.0, 40.0)
DURATION_S, SCORED_S = 200.0, 40.0
"""The integral settles with (1 + Kp)/Ki, 10 s at most below the limit cycle; the rest is scored."""
TONE_HZ = 1.0
"""Where equation (3) is read as printed: the frequency of the disturbance (assumed)."""


def steady_noise(system: System, seed: int = 0) -> dict[str, float]:
    """Return the standard deviations of f_a and u (N) with set-point and disturbance held, from a simulation."""
    run = simulate(held(system), DURATION_S, seed)
    scored = run.isel(time=slice(-round(SCORED_S * system.controller.rate_hz), None))
    return {name: float(scored[name].std()) for name in ("f_a", "u")}


def simulated_gain(system: System, seed: int = 0) -> dict[str, float]:
    """Return sigma_f / sigma_n and sigma_u / sigma_n of a simulation, N/N."""
    return {name: sigma / system.sensor.noise_rms_n for name, sigma in steady_noise(system, seed).items()}


def noise_gain(system: System) -> xr.Dataset:
    """Return sigma_f / sigma_n and sigma_u / sigma_n over kp: simulated, exact, and by equation (3) at one frequency.

    ``simulated_f``, ``simulated_u`` lie over ``kp_simulated``; ``exact_f``, ``exact_u`` (discrete Lyapunov equation)
    and ``tone`` (|G/(1+G)| at 1 Hz) over ``kp``, up to ``kp_limit``.
    """
    limit = kp_limit(system)
    kps = np.geomspace(0.5, 0.999 * limit, 60)
    loops = [linearise(held(system).evolve({"controller.kp": kp})) for kp in kps]
    sigma = system.sensor.noise_rms_n
    simulated = [simulated_gain(system.evolve({"controller.kp": kp})) for kp in SIMULATED_KPS]
    return xr.Dataset(
        {
            "exact_f": ("kp", [output_noise_rms_n(loop) / sigma for loop in loops]),
            "exact_u": ("kp", [command_noise_rms_n(loop) / sigma for loop in loops]),
            "tone": ("kp", [float(equation_3_rms_n(loop, [TONE_HZ])[0]) / sigma for loop in loops]),
            "simulated_f": ("kp_simulated", [gain["f_a"] for gain in simulated]),
            "simulated_u": ("kp_simulated", [gain["u"] for gain in simulated]),
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
