"""The same fingers under the lookup table alone: how large the error is in open loop, beside that of the loop."""

from __future__ import annotations

from typing import Any

import xarray as xr

from frictionloop.cli import screen
from frictionloop.loop.open_loop import OPEN_ERROR, OPENED
from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System
from frictionloop.physics.fingers import Fingers
from frictionloop.quantities import FrictionloopError


def with_open_loop(
    result: xr.Dataset, system: System, people: Fingers, duration_s: float, seeds: int, **options: Any
) -> xr.Dataset:
    """Return the result with the rms error of each run in open loop beside ``rms_error``.

    As it was where that error is not asked for, where the system is in open loop already, and where the open loop has
    no number. ``options`` are those of ``sweep``.
    """
    if "rms_error" not in result or system.controller.kind == OPENED["controller.kind"]:
        return result
    try:
        opened = sweep(system.evolve(OPENED), people, duration_s, seeds, ["rms_error"], **options)
    except FrictionloopError as why:  # a run without a number, say
        screen.say(f"the error in open loop is left out: {why}")
        return result
    error = opened["rms_error"].rename(OPEN_ERROR).assign_attrs(long_name="rms error in open loop")
    found = result.assign({OPEN_ERROR: error})
    names = [name for name in found.data_vars if name != OPEN_ERROR]
    at = names.index("rms_error") + 1
    return found[[*names[:at], OPEN_ERROR, *names[at:]]]
