"""The same run with the loop open, and with a steady disturbance: how much of what varies the loop leaves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.metrics import kept, of_a_run
from frictionloop.loop.record import system_of
from frictionloop.loop.simulate import traced
from frictionloop.parameters import Constant

OPENED = {"controller.kind": "lookup", "controller.form": "float"}
"""What opens a loop: the lookup table alone turns the set-point into an amplitude (paper, Sec. 2.2)."""
OPEN_ERROR = "open_loop_rms_error"
"""Name of the rms error in open loop beside that of the loop."""
LEAST_N = 1e-5
"""A variation (rms) below this is nothing to judge a loop by: a thousandth of that of a finger (assumed)."""


def open_loop_of(run: xr.Dataset) -> xr.Dataset | None:
    """Return the run of the same system, seed and duration under the lookup table alone.

    None for what was measured on a device, whose disturbance does not come again.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``.

    Raises
    ------
    FrictionloopError
        For a run without its System.
    """
    return _again(run, OPENED)


@of_a_run
def disturbance_left(run: xr.Dataset, mask: Any = None) -> float:
    """Return how much of the disturbance's variation is left in the force, by the same run with its mean alone.

        rms(f_a - f_a with d = mean(d)) / rms(d - mean(d))

    Both runs have the same finger, set-point and noise, so errors that are there anyway do not count. 0: all is
    cancelled; 1: none, as in open loop; above 1: the loop makes it worse, as one that rings does. NaN for a
    disturbance that is constant or varies by less than 0.01 mN rms, and for what was measured on a device, whose
    finger does not come again.
    """
    if "d" not in run:
        return math.nan
    keep = kept(run, mask)
    calm = steady_of(run, mask)
    varies_n = float(np.std(run["d"].values[keep]))
    return math.nan if calm is None else _rms((run["f_a"].values - calm["f_a"].values)[keep]) / varies_n


def steady_of(run: xr.Dataset, mask: Any = None) -> xr.Dataset | None:
    """Return the run of the same system, seed and duration with the mean of what is scored as disturbance.

    None for a constant disturbance, and for what was measured on a device.

    Raises
    ------
    FrictionloopError
        For a run without its System.
    """
    scored = run["d"].values[kept(run, mask)]
    steady = {"disturbance": Constant(offset_n=float(scored.mean()))}
    return _again(run, steady) if float(np.std(scored)) > LEAST_N else None


def _again(run: xr.Dataset, changes: dict[str, Any]) -> xr.Dataset | None:
    """Return the run of the same seed and duration with changes of its System; None for one of a device."""
    system = system_of(run)
    if run.attrs.get("source") != "simulated" or "seed" not in run.attrs:
        return None
    duration_s = run.sizes["time"] / system.controller.rate_hz
    (found,) = traced([system.evolve(changes)], [int(run.attrs["seed"])], duration_s)
    return found


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
