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
from frictionloop.loop.metrics import out_of_reach, reach_of
from frictionloop.loop.record import system_of
from frictionloop.parameters.still import stirring
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

MOST = 0.5
"""Share of the time out of reach from which on no frequency tells what is left."""

OWN = "the finger's own taken off: "


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


def lines(run: xr.Dataset, mask: np.ndarray) -> list[str]:
    """Return a sentence on both parts; nothing without a recording read as meant, or where they are not known."""
    system = system_of(run)
    if not mask.any() or system.disturbance.kind not in RECORDED or asked(system, "size", "signs"):
        return []
    if (missed := float(out_of_reach(run, mask).mean())) > MOST:
        said = beyond(run, mask, missed)
        return [*textwrap.wrap(entered(run, mask), WIDTH), *textwrap.wrap(said, WIDTH)]
    if system.controller.kind == "lookup":
        said = "The loop is open: of the disturbance all is left, at every frequency."
        return [*textwrap.wrap(entered(run, mask), WIDTH), said]
    split_hz = amplified_from_hz(run, mask)
    if split_hz is None:
        return []
    parts = disturbance_left_by_band(run, [0.0, split_hz, math.inf], mask).values
    if np.isnan(parts).all():
        return []
    larger = "feedback makes a variation larger."
    if math.isnan(parts[0]):
        said = f"The recording has next to nothing below {split_hz:.3g} Hz; above, {parts[1]:.0%} of its variation is "
        said += f"left (rms): there {larger}"
    elif math.isnan(parts[1]):
        said = f"The recording has next to nothing above {split_hz:.3g} Hz, from where on {larger}"
    else:
        said = f"Below {split_hz:.3g} Hz {parts[0]:.0%} of the recorded variation is left, above {parts[1]:.0%} (rms), "
        said += f"{OWN if stirring(system) else ''}from there on {larger}"
    return [*textwrap.wrap(entered(run, mask), WIDTH), *textwrap.wrap(said, WIDTH)]


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
    return f"Where scored, the disturbance varies by {d}, the force f_a by {force}{own}."
