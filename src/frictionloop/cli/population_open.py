"""The same fingers under the lookup table alone: how large the error is in open loop, beside that of the loop."""

from __future__ import annotations

from typing import Any

import xarray as xr

from frictionloop.loop.open_loop import OPENED
from frictionloop.loop.sweep import SweepInterrupted, sweep
from frictionloop.parameters import System
from frictionloop.physics.fingers import Fingers

NAME = "open_loop_rms_error"


def with_open_loop(
    result: xr.Dataset, system: System, people: Fingers, duration_s: float, seeds: int, **options: Any
) -> xr.Dataset:
    """Return the result with the rms error of each run in open loop beside ``rms_error``.

    As it was where that error is not asked for, where the system is in open loop already, and after Ctrl-C.
    ``options`` are those of ``sweep``.
    """
    if "rms_error" not in result or system.controller.kind == OPENED["controller.kind"]:
        return result
    try:
        opened = sweep(system.evolve(OPENED), people, duration_s, seeds, ["rms_error"], **options)
    except SweepInterrupted:
        return result
    found = result.assign({NAME: opened["rms_error"].rename(NAME)})
    names = [name for name in found.data_vars if name != NAME]
    at = names.index("rms_error") + 1
    return found[[*names[:at], NAME, *names[at:]]]
