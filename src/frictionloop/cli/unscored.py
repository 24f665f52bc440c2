"""What no metric says of a run: a force beyond the sensor's range, and strokes too short for feedback."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.cli.advice_text import WIDTH
from frictionloop.loop.misread import no_feedback
from frictionloop.loop.record import system_of
from frictionloop.parameters import SuspendedSensor

if TYPE_CHECKING:
    import xarray as xr


def lines(run: xr.Dataset, score_from_s: float) -> list[str]:
    """Return the lines; none of a run without either."""
    said = [no_feedback(system_of(run)), beyond_sensor(run, score_from_s)]
    return [line for each in said for line in textwrap.wrap(each, WIDTH)]


def beyond_sensor(run: xr.Dataset, score_from_s: float) -> str:
    """Return for how much of the time the force is above what the sensor can read; empty if it never is."""
    system = system_of(run)
    if not isinstance(system.sensor, SuspendedSensor):
        return ""
    f_a = run["f_a"].values[run["time"].values >= score_from_s]
    share = float(np.mean(f_a > system.sensor.range_n))
    if not share:
        return ""
    ends = f"the sensor's range ends at sensor.range_n = {system.sensor.range_n:g} N, and so does its reading"
    return f"The force is up to {float(f_a.max()):.3g} N, above the range for {share:.2%} of the time: {ends}."
