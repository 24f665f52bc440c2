"""How fast the force follows each step of the set-point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from frictionloop.loop.record import system_of
from frictionloop.quantities import FrictionloopError


class StepTime(NamedTuple):
    """One step of the set-point that the force followed."""

    start_s: float
    from_n: float
    to_n: float
    to_63_s: float
    """From the step to 63 % of the way."""
    rise_s: float
    """From 10 to 90 % of the way."""


def step_times(run: xr.Dataset) -> list[StepTime]:
    """Return the times of every step of ``f_r`` whose 90 % ``f_a`` reached before the next step, a reversal or a lift.

    Way and times are counted from the old level of the set-point, first passages at control periods.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``, with a set-point of kind "steps".

    Raises
    ------
    FrictionloopError
        For a run without its System, or with a set-point of another kind.
    """
    kind = system_of(run).setpoint.kind
    if kind != "steps":
        raise FrictionloopError(f"step_times: needs steps to follow; setpoint.kind is {kind!r}, not 'steps'")
    time, r, f = (run[name].values for name in ("time", "f_r", "f_a"))
    scored = run["scored"].values if "scored" in run else np.ones(r.size, dtype=bool)
    starts = np.flatnonzero(np.diff(r)) + 1
    found: list[StepTime] = []
    for start, stop in zip(starts, np.append(starts, r.size)[1:], strict=True):
        low, high = float(r[start - 1]), float(r[start])
        way = (f[start:stop] - low) / (high - low)
        if way[0] >= 0.9:  # there already: it has not followed
            continue
        at = [_first(way >= share) for share in (0.1, 0.632, 0.9)]
        if None not in at and scored[start : start + at[2] + 1].all():  # type: ignore[operator]
            t10, t63, t90 = (time[start + k] - time[start] for k in at)  # type: ignore[operator]
            found.append(StepTime(float(time[start]), low, high, float(t63), float(t90 - t10)))
    return found


def _first(passed: np.ndarray) -> int | None:
    return int(np.argmax(passed)) if passed.any() else None
