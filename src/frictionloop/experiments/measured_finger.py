"""What a participant's own finger can be given: measured by plain strokes before and after a session."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.experiments.trial_records import force_of
from frictionloop.loop.simulate import traced
from frictionloop.parameters import System
from frictionloop.physics.reach import Reach
from frictionloop.quantities import FrictionloopError

STROKE_S = 1.5
"""Part of a plain stroke that tells the force (assumed: as long as a trial's stroke)."""
PLAIN_S = 3.0
"""Duration of the stroke without vibration, over which moisture shows (assumed)."""
MEASURED_SPREAD = 1.1
"""Loop gain over the believed one that is left to a measured finger (assumed: load and speed change by 10 %)."""
MOST_N = 2.5
"""Set-point that asks for no vibration: above the friction of any finger here, and what the sensor reaches."""


class MeasuredFinger(NamedTuple):
    """Friction of one finger, as two plain strokes show it."""

    reach: Reach
    """Without vibration and with the largest one."""
    susceptibility_per_um2: float
    """tau of g(a) = f0 exp(-tau a^2) through the two."""
    growth_per_s: float = math.nan
    """Relative growth of friction in contact, 1/s: sweat under the finger, so how moist it is."""

    @property
    def row(self) -> dict[str, float]:
        """Return its numbers by name."""
        return {**self.reach._asdict(), "susceptibility_per_um2": self[1], "growth_per_s": self[2]}

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> MeasuredFinger:
        """Return the finger of a `row`; raise FrictionloopError where a number of it is missing."""
        try:
            low_n, high_n, *rest = (float(row[name]) for name in ("low_n", "high_n", *cls._fields[1:]))
        except (KeyError, TypeError, ValueError):
            raise FrictionloopError(f"reach = {dict(row)}: is not what was measured") from None
        return cls(Reach(low_n, high_n), *rest)

    @property
    def changes(self) -> dict[str, Any]:
        """What the controller believes of this finger, by dotted name."""
        return {
            "controller.model.nominal_n": self.reach.high_n,
            "controller.model.susceptibility_per_um2": self.susceptibility_per_um2,
            "controller.model.gain_spread": MEASURED_SPREAD,
        }


def simulated_finger(system: System, seed: int = 0) -> MeasuredFinger:
    """Return what two strokes of a simulated finger show, without vibration and with the largest.

    Parameters
    ----------
    system : System
        Bench and finger.
    seed : int
        Seed of the strokes' noise.

    Raises
    ------
    FrictionloopError
        For a finger whose friction does not fall with vibration.
    """
    most = system.plate.max_amplitude_um
    (without,) = traced([system], [seed], PLAIN_S, 0.0)
    (largest,) = traced([system], [seed], STROKE_S, most)
    return measured_finger(without, largest, most)


def measured_finger(without: xr.Dataset, largest: xr.Dataset, max_amplitude_um: float) -> MeasuredFinger:
    """Return what is measured by a stroke without vibration and one with the largest amplitude, um.

    Raises
    ------
    FrictionloopError
        For strokes of which nothing is scored, or whose force does not fall with vibration.
    """
    low_n, high_n = _mean_n(largest), _mean_n(without)
    if not 0.0 < low_n < high_n:
        raise FrictionloopError(f"reach: {low_n:.3g} N with vibration: must be below {high_n:.3g}")
    tau = math.log(high_n / low_n) / max_amplitude_um**2
    return MeasuredFinger(Reach(low_n, high_n), tau, _growth_per_s(without))


def _scored(run: xr.Dataset) -> Any:
    return run["scored"].values & np.isfinite(run[force_of(run)].values)


def _mean_n(run: xr.Dataset) -> float:
    keep = _scored(run) & (run["time"].values < STROKE_S)
    return float(np.mean(run[force_of(run)].values[keep])) if keep.any() else math.nan


def _growth_per_s(run: xr.Dataset) -> float:
    """Return the slope of the force over time, over its mean."""
    keep = _scored(run)
    force, time = run[force_of(run)].values[keep], run["time"].values[keep]
    if time.size < 2 or np.ptp(time) <= 0.0:
        return math.nan
    return float(np.polyfit(time, force, 1)[0] / np.mean(force))
