"""How well a controller follows the set-point of its own file, by simulation: stable is not yet good."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionloop.design.operating_grid import at_speed
from frictionloop.loop.companion_runs import OPENED, relative_index
from frictionloop.loop.metrics import rms_error
from frictionloop.loop.run_findings import ReachSplit, reach_split
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import Recording, Strokes, System
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.force_channel import read_held

SECONDS = 10.0
"""Of signal that are simulated, the time of a default run; less where a recording ends before."""
LEAST_S = 1.0
"""A recording that is shorter says nothing."""


@dataclass(frozen=True, kw_only=True)
class Tracking:
    """RMS of f_a - f_r in N, on the finger, slip length, speed and set-point of a system."""

    seconds: float
    """Simulated."""
    scored: float
    """Share of that which counts."""
    rms_error_n: float
    reach: ReachSplit
    """The same where the set-point is out of reach, and where it is not."""
    open_loop_rms_error_n: float
    """The same with the lookup table alone, in open loop."""
    relative_index: float
    """How rough the error is to touch, over a plain stroke of the same mean force; NaN where that has no value."""
    rms_error_n_at_mm_s: Mapping[float, float]
    """The error at the slowest and the fastest speed asked for; NaN where a motion cannot be simulated so."""

    @property
    def parts(self) -> dict[str, tuple[float, float]]:
        """Return share of the time and error, N, of all that is scored, by reach, and in open loop."""
        whole = {"scored": (self.scored, self.rms_error_n), **self.reach.parts(self.scored)}
        return whole | {"open loop": (self.scored, self.open_loop_rms_error_n)}


def tracking(system: System, speeds_mm_s: Collection[float] = ()) -> Tracking | None:
    """Return how well the set-point is followed; None of a recording that is too short."""
    seconds = min(
        SECONDS, *(_seconds(each, system.controller.rate_hz) for each in (system.setpoint, system.disturbance))
    )
    if seconds < LEAST_S:
        return None
    run, opened = (simulate(each, seconds, seed=0) for each in (system, system.evolve(OPENED)))
    mask = run["scored"].values if "scored" in run else np.ones(run.sizes["time"], bool)
    return Tracking(
        seconds=seconds,
        scored=float(mask.mean()),
        rms_error_n=float(rms_error(run)),
        reach=reach_split(run, mask),
        open_loop_rms_error_n=float(rms_error(opened)),
        relative_index=_felt(run),
        rms_error_n_at_mm_s=_at_speeds(system, speeds_mm_s, seconds),
    )


def _felt(run: Any) -> float:
    try:
        return float(relative_index(run))
    except FrictionloopError:  # without a plain stroke of this mean, or a rate that the filter is not made for
        return math.nan


def _at_speeds(system: System, speeds_mm_s: Collection[float], seconds: float) -> dict[float, float]:
    """Return the error at the slowest and the fastest; a finger in contacts of one stroke lifts in time with it."""
    motion = system.motion
    if not isinstance(motion, Strokes):
        return {}
    found, own = {}, motion.speed_mm_s
    for each in sorted({end(speeds_mm_s, default=own) for end in (min, max)} - {own}):
        try:
            found[each] = float(rms_error(simulate(at_speed(system, each), seconds, seed=0)))
        except FrictionloopError:  # of a stroke without a plateau, say
            found[each] = math.nan
    return found


def _seconds(signal: Any, rate_hz: float) -> float:
    """Return how long a run of a signal may be."""
    if isinstance(signal, Recording):
        return (read_held(signal, rate_hz).size - 1) / rate_hz
    return float(signal.longest_s)
