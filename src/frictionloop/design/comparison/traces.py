"""What the figures of a comparison show: steps and sensitivity of each law on the median finger."""

from __future__ import annotations

import numpy as np
import xarray as xr

from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.margins import begun, loop_at, median_system
from frictionloop.design.comparison.run import Comparison
from frictionloop.loop.simulate import simulate

STEPS_S = 2.0
LEVEL_N = 0.6
"""Where |S| is taken: the middle of the levels."""


def step_traces(comparison: Comparison, speed_mm_s: float) -> xr.Dataset:
    """Return ``f_r`` and ``f_a`` (N) over law, contact and time: the first steps of the median finger.

    Empty if no finger is capable at that speed.
    """
    runs = []
    for law in comparison.laws:
        for contact in protocol.CONTACTS:
            system = begun(comparison, law, speed_mm_s, contact)
            if system is None:
                return xr.Dataset()
            stepped = system.evolve({"setpoint": protocol.setpoint_of(protocol.STEPPED, STEPS_S)})
            run = simulate(stepped, STEPS_S, protocol.noise_seed(comparison.seed, protocol.STEPPED))[["f_r", "f_a"]]
            run.attrs = {}
            runs.append(run.expand_dims(law=[law], contact=[contact]))
    traces = xr.combine_by_coords(runs, combine_attrs="drop")
    # Combining sorts by name; the order of the laws decides their colours.
    return traces.sel(law=list(comparison.laws))  # type: ignore[return-value]


def sensitivities(
    comparison: Comparison, speed_mm_s: float, frequency_hz: np.ndarray
) -> dict[tuple[str, str], np.ndarray | None]:
    """Return |S| by law and contact around 0.6 N: None if a loop is unstable, no entry if it is not linear."""
    found: dict[tuple[str, str], np.ndarray | None] = {}
    for law in comparison.laws:
        for contact in protocol.CONTACTS:
            system = median_system(comparison, law, speed_mm_s, contact)
            loop = None if system is None else loop_at(system, LEVEL_N, comparison.middle_s)
            if loop is not None:
                found[law, contact] = np.abs(loop.responses(frequency_hz)["S"]) if loop.is_stable() else None
    return found
