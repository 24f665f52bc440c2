"""The same run with the loop open, and how much of its error the loop leaves."""

from __future__ import annotations

import math
from typing import Any

import xarray as xr

from frictionloop.loop.metrics import of_a_run, rms_error
from frictionloop.loop.record import system_of
from frictionloop.loop.simulate import simulate

OPENED = {"controller.kind": "lookup", "controller.form": "float"}
"""What opens a loop: the lookup table alone turns the set-point into an amplitude (paper, Sec. 2.2)."""


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
    system = system_of(run)
    if run.attrs.get("source") != "simulated" or "seed" not in run.attrs:
        return None
    duration_s = run.sizes["time"] / system.controller.rate_hz
    return simulate(system.evolve(OPENED), duration_s, int(run.attrs["seed"]))


@of_a_run
def error_left(run: xr.Dataset, mask: Any = None) -> float:
    """Return the rms of f_a - f_r over that of the same run in open loop: 0 is all cancelled, above 1 is worse.

    NaN where the loop cannot be opened (`open_loop_of`), or leaves no error either.
    """
    opened = open_loop_of(run)
    alone = math.nan if opened is None else rms_error(opened, mask)
    return rms_error(run, mask) / alone if alone > 0 else math.nan
