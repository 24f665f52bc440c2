"""The systems the report compares: each reading of the printed amplitudes, and a set-point that can be reached."""

from __future__ import annotations

import numpy as np

from frictionloop.parameters import READINGS, Constant, System, feasible, paper
from frictionloop.physics.friction import friction_force
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


def held(system: System) -> System:
    """Return a system with set-point and disturbance held at their means, as equation (3) assumes."""
    return system.evolve(
        {
            "setpoint": Constant(offset_n=getattr(system.setpoint, "offset_n", 0.0)),
            "disturbance": Constant(offset_n=getattr(system.disturbance, "offset_n", 0.0)),
        }
    )


def reachable_share(system: System, duration_s: float = 10.0) -> float:
    """Return the share of control periods at which f_r lies in [g(a_max) + d, f0 + d], 0 to 1."""
    time = np.arange(round(duration_s * system.controller.rate_hz)) / system.controller.rate_hz
    f_r, d = evaluate(system.setpoint, time), evaluate(system.disturbance, time)  # type: ignore[arg-type]
    floor = float(friction_force(system.plate.max_amplitude_um, system.friction))
    return float(np.mean((f_r >= floor + d) & (f_r <= system.friction.nominal_n + d)))
