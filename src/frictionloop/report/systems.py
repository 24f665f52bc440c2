"""The systems that the report compares, their runs at the three proportional gains, and the noise heard in them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from scipy.signal import welch

from frictionloop.analysis.linear import check_pi
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import READINGS, Constant, System, feasible, paper
from frictionloop.physics.reach import reach
from frictionloop.physics.sources import evaluate

WORKING = "peak-to-peak"
"""The reading that ``paper()`` takes of the printed amplitudes."""
FEASIBLE = "reachable set-point"
"""Not a reading: ``feasible()``, the same loop asked for forces it can give."""


def readings() -> dict[str, System]:
    """Return the systems of the printed text, by the name of the reading; the working one is first."""
    return {name: paper().evolve(overrides) for name, overrides in READINGS.items()}


def compared() -> dict[str, System]:
    """Return ``readings`` and the system with a reachable set-point, which is last."""
    return readings() | {FEASIBLE: feasible()}


PER_SAMPLE = "Ki per sample"
"""The other reading of a Ki without a unit: 2 is added in every control period."""


def per_sample(system: System) -> System:
    """Return a system whose ki is what the same number per control period would be, in 1/s."""
    return system.evolve({"controller.ki": check_pi(system).ki * system.controller.rate_hz})


def in_both_units(systems: Mapping[str, System]) -> dict[str, System]:
    """Return systems with Ki per second, then with Ki per sample, which their names then say."""
    return {**systems, **{f"{name}, {PER_SAMPLE}": per_sample(system) for name, system in systems.items()}}


def held(system: System) -> System:
    """Return a system with set-point and disturbance held at their means, as equation (3) assumes."""
    return system.evolve(
        {
            "setpoint": Constant(offset_n=getattr(system.setpoint, "offset_n", 0.0)),
            "disturbance": Constant(offset_n=getattr(system.disturbance, "offset_n", 0.0)),
        }
    )


def reachable_share(system: System) -> float:
    """Return the share of control periods of 10 s at which f_r lies in [g(a_max) + d, f0 + d], 0 to 1."""
    time = np.arange(round(10.0 * system.controller.rate_hz)) / system.controller.rate_hz
    f_r, d = evaluate(system.setpoint, time), evaluate(system.disturbance, time)  # type: ignore[arg-type]
    there = reach(system.friction, system.motion, system.plate.max_amplitude_um).plus(d)
    return float(np.mean(~there.beyond(f_r)))


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


def noise_above_n(run: xr.Dataset) -> float:
    """Return the rms of f_a above `NOISE_FROM_HZ` in N: the square root of its spectrum's integral (Welch)."""
    rate_hz = 1.0 / float(run["time"][1] - run["time"][0])
    frequency, density = welch(run["f_a"].values, rate_hz, nperseg=2048)
    above = frequency >= NOISE_FROM_HZ
    return float(np.sqrt(np.trapezoid(density[above], frequency[above])))
