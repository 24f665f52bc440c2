"""Recorded signals as levels, of which a design and the linear analysis know."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

RECORDED, OFTEN_N = ("recording", "samples"), 0.2
"""Kinds of signals that are measured, and the mean from which a disturbance is asked about (chosen)."""


def at_levels(system: System, run: xr.Dataset | None = None, mask: np.ndarray | None = None) -> System:
    """Return the system with levels in the place of recorded signals: of those in a run, or in their files without one.

    A set-point is a sine from its lowest to its highest value. A disturbance is its mean, or 0 where that was left in,
    as `left_in` has it. A device's recording knows no disturbance: its system keeps what it has.
    """
    from frictionloop.parameters import Constant, Sine

    levels: dict[str, Any] = {}
    if (asked := _range_and_mean("setpoint", system, run, mask)) is not None:
        low_n, high_n, _ = asked
        levels["setpoint"] = Sine(offset_n=(high_n + low_n) / 2, amplitude_n=(high_n - low_n) / 2)
    if (added := _range_and_mean("disturbance", system, run, mask)) is not None:
        levels["disturbance"] = Constant(offset_n=0.0 if left_in(system, added[2]) else added[2])
    return system.evolve(levels) if levels else system


def left_in(system: System, mean_n: float) -> bool:
    """Tell whether a recorded disturbance seems to hold the mean friction, which the model has already."""
    removed = getattr(system.disturbance, "remove_mean", False)
    return system.disturbance.kind in RECORDED and not removed and abs(mean_n) > OFTEN_N


def _range_and_mean(
    name: str, system: System, run: xr.Dataset | None, mask: np.ndarray | None
) -> tuple[float, float, float] | None:
    """Return lowest, highest and mean value in N of a recorded signal; None of another, or where it is not known."""
    signal = getattr(system, name)
    if signal.kind not in RECORDED:
        return None
    if run is not None:
        column = {"setpoint": "f_r", "disturbance": "d"}[name]
        if column not in run:
            return None
        values = run[column].values[mask]
    elif signal.kind == "recording":
        from frictionloop.recordings.told import found

        read = found(signal)
        return read.lowest_n, read.highest_n, read.mean_n
    else:
        values = signal.values_n
    return float(np.min(values)), float(np.max(values)), float(np.mean(values))
