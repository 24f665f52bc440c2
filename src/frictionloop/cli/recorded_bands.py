"""What a loop leaves of a recorded disturbance, below and above the frequency from which on it makes it larger."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.analysis.levels import RECORDED, at_levels
from frictionloop.cli.recorded import WIDTH
from frictionloop.cli.recorded_units import asked
from frictionloop.loop.bands import disturbance_left_by_band
from frictionloop.loop.metrics import out_of_reach, reach_of, rms_error
from frictionloop.loop.open_loop import disturbance_left
from frictionloop.loop.record import system_of
from frictionloop.parameters import Recording
from frictionloop.parameters.still import stirring
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

MOST = 0.5
"""Share of the time out of reach from which on no frequency tells what is left."""

START_S, APART = 0.1, 0.05
"""Time in which a loop begins, and the share of what is left from which on it is told (both chosen)."""
MEAN = 0.5
"""Share of the rms error from which on it is told that its mean is (chosen)."""
OWN = ", the finger's own taken off"


def searched(run: xr.Dataset, mask: np.ndarray, response: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Return frequencies in Hz and the size of a response there, of the loop at the mean of what is asked.

    None of a loop that has no linear analysis, or is not stable in it.
    """
    from frictionloop.analysis import operating_band

    try:
        points = operating_band(at_levels(system_of(run), run, mask))
        loop = points[len(points) // 2]
        grid = loop.search_grid(0.1)
        size = np.abs(loop.frequency_response(grid)[response].values)
    except (FrictionloopError, KeyError):  # a law that has no linear analysis
        return None
    return (grid, size) if loop.is_stable() else None


def amplified_from_hz(run: xr.Dataset, mask: np.ndarray) -> float | None:
    """Return the lowest frequency at which |S| is 1; None without one."""
    found = searched(run, mask, "S")
    if found is None:
        return None
    grid, size = found
    over = np.flatnonzero((size[1:] >= 1.0) & (size[:-1] < 1.0))
    return float(grid[over[0] + 1]) if over.size else None


def lines(run: xr.Dataset, mask: np.ndarray, split: bool = False) -> list[str]:
    """Return a sentence on both parts; nothing without a recording read as meant, or where they are not known.

    ``split`` says that rows tell what is left below and above other frequencies: then only where feedback ends.
    """
    system = system_of(run)
    if not mask.any() or system.disturbance.kind not in RECORDED:
        return []
    if asked(system, "size", "signs"):
        said = "From which frequency on feedback makes a variation larger is not told while it is not clear what the "
        return textwrap.wrap(said + "recording is.", WIDTH)
    parts = _by_band(run, mask, system, split)
    told = [entered(run, mask), parts, at_the_start(run, mask)] if parts else []
    return [line for each in told for line in textwrap.wrap(each, WIDTH)]


def at_the_start(run: xr.Dataset, mask: np.ndarray) -> str:
    """Return how much less is left without the first moments, before a loop has acted; empty where that is as much."""
    time_s = run["time"].values
    late = mask & (time_s >= time_s[0] + START_S)
    if not (mask & ~late).any() or np.count_nonzero(late) <= np.count_nonzero(mask) / 2:
        return ""
    whole, rest = disturbance_left(run, mask), disturbance_left(run, late)
    if not rest < whole / (1.0 + APART):
        return ""
    return (
        f"Without the first {START_S:g} s, in which the loop begins, {rest:.3g} of the disturbance is left: "
        f"--score-from-s {START_S:g} leaves them out."
    )


def _by_band(run: xr.Dataset, mask: np.ndarray, system: System, split: bool) -> str:
    """Return what is left below and above a frequency, or why there is no such thing; empty where it is not known."""
    if (missed := float(out_of_reach(run, mask).mean())) > MOST:
        return beyond(run, mask, missed)
    if system.controller.kind == "lookup":
        return "The loop is open: of the disturbance all is left, at every frequency."
    split_hz = amplified_from_hz(run, mask)
    if split_hz is None:
        return ""
    return _at(split_hz, run, mask, OWN if stirring(system) else "", split)


def _at(split_hz: float, run: xr.Dataset, mask: np.ndarray, own: str, split: bool) -> str:
    """Return what is left below and above a frequency; empty where neither part is there."""
    below, above = disturbance_left_by_band(run, [0.0, split_hz, math.inf], mask).values
    larger = "feedback gains nothing." if above < 1.0 else "feedback makes a variation larger."
    if math.isnan(below) and math.isnan(above):
        return ""
    if math.isnan(below):
        said = f"The recording has next to nothing below {split_hz:.3g} Hz; above, {above:.0%} of its variation is "
        return f"{said}left (rms): there {larger}"
    if math.isnan(above):
        ends_hz = ends_at_hz(system_of(run))
        if ends_hz < split_hz:
            return f"The recording ends at {ends_hz:.3g} Hz, half its rate; from {split_hz:.3g} Hz on {larger}"
        return f"The recording has next to nothing above {split_hz:.3g} Hz, from where on {larger}"
    if split:
        return f"|S| of the linear loop first reaches 1 at {split_hz:.3g} Hz: above, in all, {larger}"
    said = f"Below {split_hz:.3g} Hz {below:.0%} of the recorded variation is left, above {above:.0%} (rms){own}. "
    return f"{said}|S| of the linear loop first reaches 1 there: above, in all, {larger}"


def ends_at_hz(system: System) -> float:
    """Return half the rate of a recorded disturbance, above which its file has nothing; infinite if a run has less."""
    if not isinstance(system.disturbance, Recording):
        return math.inf
    from frictionloop.recordings.told import found

    rate_hz = found(system.disturbance).rate_hz
    return rate_hz / 2.0 if rate_hz < system.controller.rate_hz else math.inf


def beyond(run: xr.Dataset, mask: np.ndarray, missed: float) -> str:
    """Return that a loop can do next to nothing about a disturbance, for vibration cannot make up for it."""
    (floor, top), d = reach_of(run, mask), run["d"].values[mask]
    most_n = float(np.median(top - floor))
    return (
        f"The loop can do nothing about it {missed:.0%} of the time: vibration lowers the friction by {most_n:.3g} N "
        f"at most. The disturbance goes from {float(d.min()):.3g} to {float(d.max()):.3g} N."
    )


def entered(run: xr.Dataset, mask: np.ndarray) -> str:
    """Return what the disturbance that entered, and the force on the finger, vary by where scored."""
    d, force = (
        f"{1e3 * float(np.std(values)):.3g} mN rms about {float(np.mean(values)):.3g} N"
        for values in (run["d"].values[mask], run["f_a"].values[mask])
    )
    own = ", the finger's own included" if stirring(system_of(run)) else ""
    left = disturbance_left(run, mask)
    of_it = "" if math.isnan(left) else f", of which {1e3 * left * float(np.std(run['d'].values[mask])):.3g} mN is left"
    return (
        f"Where scored, the disturbance varies by {d}{of_it}; the force f_a varies by {force}{own}{_aside(run, mask)}."
    )


def _aside(run: xr.Dataset, mask: np.ndarray) -> str:
    """Return what of the force is the start of the run, and how far its mean is from the set-point's."""
    f_a, time_s = run["f_a"].values, run["time"].values
    late, said = mask & (time_s >= time_s[0] + START_S), ""
    if np.count_nonzero(late) > np.count_nonzero(mask) / 2:
        rest_n = float(np.std(f_a[late]))
        if float(np.std(f_a[mask])) > (1.0 + APART) * rest_n:
            said = f", without the first {START_S:g} s by {1e3 * rest_n:.3g} mN"
    mean_n, error_n = float(np.mean((f_a - run["f_r"].values)[mask])), rms_error(run, mask)
    if abs(mean_n) > MEAN * error_n:
        said += (
            f". Its mean is {1e3 * abs(mean_n):.3g} mN {'above' if mean_n > 0.0 else 'below'} that of the set-point, "
        )
        said += "which counts in rms_error"
    return said
