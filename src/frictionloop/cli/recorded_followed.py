"""How far a loop follows a recorded set-point: up to which frequency, and what error is left below and above it."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from frictionloop.analysis.levels import RECORDED
from frictionloop.cli.recorded import WIDTH
from frictionloop.cli.recorded_bands import MOST, searched
from frictionloop.cli.recorded_units import asked
from frictionloop.loop.bands import LEAST, rms_by_band
from frictionloop.loop.metrics import out_of_reach
from frictionloop.loop.record import system_of
from frictionloop.parameters.still import stirring

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


class Part(NamedTuple):
    """Part of a set-point below or above a frequency."""

    asked_n: float
    """What f_r varies by there, rms."""
    error_n: float
    """What f_a - f_r varies by there, rms."""

    @property
    def share(self) -> float:
        """Error over what is asked."""
        return self.error_n / self.asked_n


def error_by_band(run: xr.Dataset, mask: np.ndarray, split_hz: float) -> tuple[Part, Part]:
    """Return what f_r and f_a - f_r vary by (rms) below and above a frequency.

    As `rms_by_band` has them. An error that stays is none of a frequency, and does not count.
    """
    signals = (run["f_r"].values, (run["f_a"] - run["f_r"]).values)
    found = [rms_by_band(each, run["time"].values, mask, (0.0, split_hz, math.inf)) for each in signals]
    below, above = np.transpose(found).tolist()
    return Part(*below), Part(*above)


def lines(run: xr.Dataset, mask: np.ndarray) -> list[str]:
    """Return what is said of it; nothing without a recorded set-point read as meant, or a stable linear loop."""
    system = system_of(run)
    if not mask.any() or system.setpoint.kind not in RECORDED or asked(system, "size", "signs"):
        return []
    to_hz = followed_to_hz(run, mask)
    if to_hz is None or float(out_of_reach(run, mask).mean()) > MOST:  # which the run says by itself
        return []
    below, above = error_by_band(run, mask, to_hz)
    said = f"The force follows the recorded set-point up to {to_hz:.3g} Hz (linear, within 3 dB at its mean). "
    least_n = LEAST * math.hypot(below.asked_n, above.asked_n)
    if below.asked_n > least_n:
        said += f"Below that the error varies by {below.share:.0%} of what is asked (rms). "
    own = ", the finger's own tremor, drift and roughness included" if stirring(system) else ""
    wanted = f"{1e3 * above.asked_n:.3g} mN rms are" if above.asked_n > least_n else "next to nothing is"
    said += f"Above it {wanted} asked, and the error varies by {1e3 * above.error_n:.3g} mN{own}."
    return textwrap.wrap(said, WIDTH)
