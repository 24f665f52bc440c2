"""What a loop leaves of a recorded disturbance, below and above the frequency from which on it makes it larger."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.cli.advice import RECORDED, around_a_level
from frictionloop.cli.recorded import WIDTH
from frictionloop.cli.recorded_units import too_large
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr


def amplified_from_hz(run: xr.Dataset, mask: np.ndarray) -> float | None:
    """Return the lowest frequency at which |S| is 1, of the loop at the mean of what is asked; None without one."""
    from frictionloop.analysis import operating_band
    from frictionloop.loop.record import system_of

    try:
        points = operating_band(around_a_level(system_of(run), run, mask))
        loop = points[len(points) // 2]
        grid = loop.search_grid(0.1)
        size = np.abs(loop.frequency_response(grid)["S"].values)
    except (FrictionloopError, KeyError):  # a law that has no linear analysis
        return None
    over = np.flatnonzero((size[1:] >= 1.0) & (size[:-1] < 1.0))
    return float(grid[over[0] + 1]) if loop.is_stable() and over.size else None


def left_by_band(run: xr.Dataset, mask: np.ndarray, split_hz: float) -> tuple[float, float] | None:
    """Return what `disturbance_left` is of the parts below and above a frequency; None where that is not known.

    Both signals are split by a discrete Fourier transform over the whole run, and scored as all else.
    """
    from frictionloop.loop.open_loop import LEAST_N, steady_of

    calm = steady_of(run, mask)
    if calm is None:
        return None
    left, given = (run["f_a"] - calm["f_a"]).values, (run["d"] - calm["d"]).values
    shares = [
        _rms(part[mask]) / max(_rms(whole[mask]), LEAST_N)
        for part, whole in zip(_split(left, run, split_hz), _split(given, run, split_hz), strict=True)
    ]
    return shares[0], shares[1]


def lines(run: xr.Dataset, mask: np.ndarray) -> list[str]:
    """Return a sentence on both parts; nothing without a recording in its unit, or where they are not known."""
    from frictionloop.loop.record import system_of

    system = system_of(run)
    if not mask.any() or system.disturbance.kind not in RECORDED or too_large(system):
        return []
    split_hz = amplified_from_hz(run, mask)
    parts = None if split_hz is None else left_by_band(run, mask, split_hz)
    if parts is None or not all(map(math.isfinite, parts)):
        return []
    said = f"Below {split_hz:.3g} Hz {parts[0]:.0%} of the recorded variation is left, above {parts[1]:.0%} (rms): "
    return textwrap.wrap(said + "from there on feedback makes a variation larger.", WIDTH)


def _split(values: np.ndarray, run: xr.Dataset, split_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts of a signal below and above a frequency."""
    time = run["time"].values
    spectrum = np.fft.rfft(values)
    spectrum[np.fft.rfftfreq(values.size, time[1] - time[0]) > split_hz] = 0.0
    low = np.fft.irfft(spectrum, values.size)
    return low, values - low


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
