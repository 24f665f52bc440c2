"""What no metric says of a run: the force where the finger turns round or lands, and one beyond the sensor's range."""

from __future__ import annotations

import itertools
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.cli.advice_text import WIDTH
from frictionloop.loop.record import system_of
from frictionloop.parameters import Strokes, SuspendedSensor

if TYPE_CHECKING:
    import xarray as xr

TIMES = 3.0
"""Error over the rms error of what is scored from which on a reversal is told (chosen)."""


def lines(run: xr.Dataset, score_from_s: float, error_n: float) -> list[str]:
    """Return the lines; none of a run without either."""
    said = [at_reversals(run, score_from_s, error_n), beyond_sensor(run, score_from_s)]
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


def at_reversals(run: xr.Dataset, score_from_s: float, error_n: float) -> str:
    """Return how far the force is above the set-point at reversals and landings, for how long; empty if it is not."""
    system = system_of(run)
    if not isinstance(system.motion, Strokes) or "scored" not in run or not error_n > 0.0:
        return ""
    time_s, f_a, f_r = (run[name].values for name in ("time", "f_a", "f_r"))
    on = run["load"].values > system.touch.load.touch_n
    there = on & ~run["scored"].values & (time_s >= score_from_s)
    above_n = np.where(there, f_a - f_r, 0.0)
    high = above_n > TIMES * error_n
    if not high.any():
        return ""
    worst = int(np.argmax(above_n))
    lasts = [sum(1 for _ in group) for is_high, group in itertools.groupby(high) if is_high]
    longest_ms = 1e3 * max(lasts) / system.controller.rate_hz
    clamped = float(run["saturated"].values[high].mean())
    said = f"Not scored: where the finger turns round or lands the force goes up to {f_a[worst]:.3g} N "
    said += f"(at {time_s[worst]:.4g} s, "
    said += f"{f_r[worst]:.3g} N asked for). It is more than {TIMES:g} times the rms error above the set-point "
    said += f"{len(lasts)} time{'s' * (len(lasts) > 1)}, for up to {longest_ms:.3g} ms"
    said += f", with the command clamped {clamped:.0%} of that" if clamped > 0.0 else ""
    return said + "."
