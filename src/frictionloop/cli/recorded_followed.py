"""How far a loop follows a recorded set-point: up to which frequency, and what error is left below and above it."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.analysis.levels import RECORDED
from frictionloop.cli.recorded import WIDTH
from frictionloop.cli.recorded_bands import LEAST, searched, split
from frictionloop.cli.recorded_units import asked
from frictionloop.loop.record import system_of

if TYPE_CHECKING:
    import xarray as xr

WITHIN = math.sqrt(2.0)
"""Factor up or down up to which an amplitude is followed: 3 dB."""


def followed_to_hz(run: xr.Dataset, mask: np.ndarray) -> float | None:
    """Return the frequency up to which the linear loop's |f_a / f_r| is within 3 dB; None without one."""
    found = searched(run, mask, "f_a_from_f_r")
    if found is None:
        return None
    grid, size = found
    off = np.flatnonzero((size > WITHIN) | (size < 1 / WITHIN))
    return float(grid[off[0]]) if off.size and off[0] else None


def error_by_band(run: xr.Dataset, mask: np.ndarray, split_hz: float) -> tuple[float, float]:
    """Return what f_a - f_r varies by (rms) below and above a frequency, as shares of what f_r varies by there.

    NaN of a part that is hardly there. Both are split as by `left_by_band`, the error with a straight line where it is
    not scored, as in reversals. An error that stays is none of a frequency, and does not count.
    """
    time = run["time"].values
    error = np.interp(time, time[mask], (run["f_a"] - run["f_r"]).values[mask])
    wanted, missed = (
        [float(np.std(part[mask])) for part in split(values, run, split_hz)] for values in (run["f_r"].values, error)
    )
    least = LEAST * math.hypot(*wanted)
    below, above = (part / of if of > least else math.nan for part, of in zip(missed, wanted, strict=True))
    return below, above


def lines(run: xr.Dataset, mask: np.ndarray) -> list[str]:
    """Return what is said of it; nothing without a recorded set-point read as meant, or a stable linear loop."""
    system = system_of(run)
    if not mask.any() or system.setpoint.kind not in RECORDED or asked(system, "size", "signs"):
        return []
    to_hz = followed_to_hz(run, mask)
    if to_hz is None:
        return []
    below, above = error_by_band(run, mask, to_hz)
    said = f"The loop follows the recorded set-point up to {to_hz:.3g} Hz (linear, within 3 dB at its mean). "
    parts = [f"{part:.0%} {name}" for name, part in (("below", below), ("above", above)) if not math.isnan(part)]
    said += f"Of what it varies by, the error is {' and '.join(parts)} (rms)." if parts else ""
    return textwrap.wrap(said.strip(), WIDTH)
