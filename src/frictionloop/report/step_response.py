"""Steps on the bench taken apart: windows around each step, response times, the skin's limit, overshoot."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from frictionloop.loop.step_times import StepTime, step_times
from frictionloop.parameters import Skin, Strokes, System
from frictionloop.report.device import OPEN, PRINTED
from frictionloop.report.people import the_finger
from frictionloop.report.protocol import STEP_LEVELS_N, finger_system

BEFORE_MS, AFTER_MS = 100.0, 400.0
"""A window around a step; the level after it lasts 500 ms."""
SETTLED_MS = 200.0
"""From here on a level counts as settled: the 37 ms of the paper and five standard deviations of it have passed."""
SHARE_10_90 = 0.8
PRINTED_MS = {"falling": (37.0, 20.0), "rising": (32.0, 16.0)}
"""Mean and standard deviation of the response (paper, Sec. 4.2)."""
DIRECTIONS = tuple(PRINTED_MS)


class Times(NamedTuple):
    """Mean and standard deviation (ms) of the times to 63 % and from 10 to 90 %, and how many steps gave them."""

    mean: tuple[float, float]
    sd: tuple[float, float]
    steps: int

    @property
    def to_63(self) -> float | None:
        """Mean time to 63 %, None where no step was followed."""
        return self.mean[0] if self.steps else None

    @property
    def from_10_to_90(self) -> float | None:
        """Mean time from 10 to 90 %, likewise."""
        return self.mean[1] if self.steps else None


def responses(runs: xr.Dataset, own_levels: bool = False) -> list[StepTime]:
    """Return the step times of all strokes, counted from the set-point's levels or from those the force settled at."""
    found: list[StepTime] = []
    for j in range(runs.sizes["stroke"]):
        run = runs.isel(stroke=j)
        found += step_times(run.assign(f_r=("time", _own_levels(run))) if own_levels else run)
    return found


def _own_levels(run: xr.Dataset) -> np.ndarray:
    """Return, for each period, the mean force over the settled part of its level."""
    rate_hz = 1.0 / float(run["time"][1] - run["time"][0])
    settled = round(1e-3 * SETTLED_MS * rate_hz)
    parts = np.split(run["f_a"].values, np.flatnonzero(np.diff(run["f_r"].values)) + 1)
    return np.concatenate([np.full(part.size, part[settled:].mean()) for part in parts])


def times_ms(runs: xr.Dataset, controller: str, direction: str) -> Times:
    """Return the response times of a controller, NaN where no step was followed.

    Without control, and where it rings, the force does not come to the set-point's levels; there they are its own.
    """
    up = direction == "rising"
    found = [each for each in responses(runs, controller in (OPEN, PRINTED)) if (each.to_n > each.from_n) == up]
    if not found:
        return Times((np.nan, np.nan), (np.nan, np.nan), 0)
    table = 1e3 * np.array([[each.to_63_s, each.rise_s] for each in found])
    (a, b), (c, d) = table.mean(axis=0).tolist(), table.std(axis=0).tolist()
    return Times((a, b), (c, d), len(found))


def step_windows(runs: xr.Dataset, direction: str) -> xr.Dataset:
    """Return f_r, f_a, a and saturated around every step of a direction, over ``step`` and ``since`` (ms)."""
    rate_hz = 1.0 / float(runs["time"][1] - runs["time"][0])
    before, after = (round(1e-3 * ms * rate_hz) for ms in (BEFORE_MS, AFTER_MS))
    since = np.arange(-before, after) / rate_hz * 1e3
    windows = []
    for j in range(runs.sizes["stroke"]):
        run = runs.isel(stroke=j)
        jumps = np.diff(run["f_r"].values)
        for k in np.flatnonzero(jumps > 0 if direction == "rising" else jumps < 0) + 1:
            if before <= k <= run.sizes["time"] - after:
                windows.append(run.isel(time=slice(k - before, k + after)).drop_vars("time"))
    return xr.concat(windows, "step").rename(time="since").assign_coords(since=since)


def overshoot(runs: xr.Dataset, direction: str) -> float:
    """Return how far the amplitude goes beyond where it settles after a step, over the step that it makes.

    Of the mean over all steps, so that what differs from step to step does not count.
    """
    amplitude = step_windows(runs, direction)["a"].mean("step")
    start = float(amplitude.sel(since=slice(-BEFORE_MS, -1)).mean())
    end = float(amplitude.sel(since=slice(SETTLED_MS, None)).mean())
    way = (amplitude.sel(since=slice(0, SETTLED_MS)) - start) / (end - start)
    return float(way.max()) - 1.0


def mean_peak_n(runs: xr.Dataset) -> float:
    """Return the largest force after a rising step, in N, of the mean over all of them."""
    return float(step_windows(runs, "rising")["f_a"].mean("step").sel(since=slice(0, SETTLED_MS)).max())


def steady_error_n(runs: xr.Dataset) -> np.ndarray:
    """Return f_a - f_r where a level has settled, in N."""
    errors = []
    for direction in DIRECTIONS:
        settled = step_windows(runs, direction).sel(since=slice(SETTLED_MS, None))
        errors.append((settled["f_a"] - settled["f_r"]).values.ravel())
    return np.concatenate(errors)


def skin_limit_ms(system: System, step_n: float) -> float:
    """Return the least time from 10 to 90 % of a rise at a steady speed, 0.8 dF/(k v) in ms.

    The tip lags no faster than the finger moves, so the skin pulls at most k v harder.
    """
    finger, motion = system.finger, system.motion
    assert isinstance(finger, Skin) and isinstance(motion, Strokes)
    return 1e3 * SHARE_10_90 * step_n / (finger.stiffness_n_m * 1e-3 * motion.speed_mm_s)


def this_skin_limit_ms() -> float:
    """Return the least time from 10 to 90 % of the steps up, for the chosen finger."""
    return skin_limit_ms(finger_system(the_finger()), STEP_LEVELS_N[1] - STEP_LEVELS_N[0])
