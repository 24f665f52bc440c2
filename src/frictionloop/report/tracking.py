"""Runs at the paper's three proportional gains, Fig. 2b to 2d, and the noise heard in them."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.signal import welch

from frictionloop.loop.simulate import simulate
from frictionloop.parameters import System

KPS = (40.0, 10.0, 1.0)
"""Proportional gains of Fig. 2b, 2c and 2d."""
NOISE_FROM_HZ = 200.0
"""Twice the highest frequency of the set-point: what lies above was not asked for."""


def tracking_run(system: System, kp: float, **overrides: float) -> xr.Dataset:
    """Return the 10 s run at one gain; further overrides as ``sensor__noise_rms_n=0.0``."""
    dotted = {path.replace("__", "."): value for path, value in overrides.items()}
    return simulate(system.evolve({"controller.kp": kp} | dotted), duration_s=10.0, seed=0)


def tracking_runs(system: System) -> dict[float, xr.Dataset]:
    """Return the runs of Fig. 2b, 2c and 2d by their gain."""
    return {kp: tracking_run(system, kp) for kp in KPS}


def noise_above_n(run: xr.Dataset, frequency_hz: float = NOISE_FROM_HZ) -> float:
    """Return the rms of f_a above a frequency in N: the square root of its spectrum's integral (Welch)."""
    rate_hz = 1.0 / float(run["time"][1] - run["time"][0])
    frequency, density = welch(run["f_a"].values, rate_hz, nperseg=2048)
    above = frequency >= frequency_hz
    return float(np.sqrt(np.trapezoid(density[above], frequency[above])))


def piece(run: xr.Dataset, start_s: float, stop_s: float) -> xr.Dataset:
    """Return the part of a run between two times in s."""
    return run.sel(time=slice(start_s, stop_s))
