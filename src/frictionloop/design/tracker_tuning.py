"""The tracker's schedule for a bench: a row of gains for each share of the way to its limit that friction goes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from frictionloop.design.tracker_loop import Row
from frictionloop.design.tracker_search import RowSearch
from frictionloop.parameters import Model, SuspendedSensor, System
from frictionloop.parameters.tracking import PLACES
from frictionloop.quantities import FrictionloopError

LIMITS: Mapping[float, float] = {0.0: 1.7, 0.025: 2.0, 0.05: 2.6}
"""Largest Ms by how far the resonance is off, relative, to either side: of a device whose ringing has been measured."""
_ERRORS, _SHARES, _QS = (0.05, 0.1), (0.96, 0.91), (7.0, 6.0)


def believed_resonance(limits: Mapping[float, float] = LIMITS) -> tuple[float, float]:
    """Return the resonance that is believed, over the true one, and its Q: low and broad, as too high is fatal.

    0.91 and 6 where it may be 10 % off (of 18 pairs tried, from 0.86 to 0.97 and 1.5 to 9, among the best within 2 %;
    at 0.92 Ms at the limits of the resonance is higher), 0.96 and 7 where it is 5 % at most, a line between.
    """
    worst = max(limits)
    return float(np.interp(worst, _ERRORS, _SHARES)), float(np.interp(worst, _ERRORS, _QS))


@dataclass(frozen=True, eq=False)
class TrackerTuning:
    """A schedule and what is predicted of it, row by row."""

    rows: tuple[Row, ...]
    true: Model
    """What the tracker has to be told of the sensor."""
    residual_n: tuple[float, ...]
    peaks: tuple[dict[float, float], ...] = field(repr=False)
    """Ms by how far the resonance is off."""
    resonance_share: float
    broadened_q: float
    """What the observer is given in place of the true resonance and Q (`believed_resonance`)."""

    @property
    def overrides(self) -> dict[str, Any]:
        """The tracker as overrides for ``System.evolve``."""
        return {
            "controller.kind": "tracker",
            "controller.schedule": tuple(tuple(float(f"{v:.4g}") for v in row) for row in self.rows),
            "controller.resonance_share": self.resonance_share,
            "controller.broadened_q": self.broadened_q,
            "controller.model.resonance_hz": self.true.resonance_hz,
            "controller.model.resonance_q": self.true.resonance_q,
            "controller.model.sensor_hz": self.true.sensor_hz,
        }


def tune_tracker(
    system: System,
    limits: Mapping[float, float] = LIMITS,
    seed: int = 0,
    *,
    progress: Callable[[], None] | None = None,
) -> TrackerTuning:
    """Return the schedule with the least predicted residual whose Ms stays below limits.

    The tracker believes that friction goes the share 1/(1 + T/dt) of the way to its limit in a period; the plants that
    are tuned go as a sampled Dahl contact under a held speed does, 1 - e^(-dt/T), which is more (`true_shares`).

    Parameters
    ----------
    system
        The bench: its sensor and rate. The delay is taken to be one period, the longest that a tracker bears, and the
        disturbance is that of `bench()`.
    limits
        Largest Ms by how far the true resonance is off to either side, relative; 0 must be among them.
    seed
        Of the starts of the search, which is local.
    progress
        Called after each row of the schedule.

    Raises
    ------
    FrictionloopError
        For a sensor without suspension, limits without 0 or not above 1, or a place at which no gains keep to them.
    """
    if not isinstance(system.sensor, SuspendedSensor):
        raise FrictionloopError(f'sensor.kind = "{system.sensor.kind}": a tracker is tuned for a "suspended" one')
    if 0.0 not in limits or not all(limit > 1.0 for limit in limits.values()):
        raise FrictionloopError(f"limits = {dict(limits)}: must have 0 and largest Ms above 1, such as {dict(LIMITS)}")
    sensor = system.sensor
    true = system.controller.model.model_copy(
        update={"resonance_hz": sensor.resonance_hz, "resonance_q": sensor.q, "sensor_hz": sensor.cutoff_hz}
    )
    share_of_true, q = believed_resonance(limits)
    believed = true.model_copy(update={"resonance_hz": share_of_true * sensor.resonance_hz, "resonance_q": q})
    found = []
    with threadpool_limits(limits=1, user_api="blas"):  # matrices of 12: more threads only wait for each other
        for place in PLACES:
            found.append(RowSearch(system, true, believed, place, limits).best(seed))
            if progress is not None:
                progress()
    rows, left, peaks = zip(*found, strict=True)
    return TrackerTuning(rows, true, left, peaks, share_of_true, q)
