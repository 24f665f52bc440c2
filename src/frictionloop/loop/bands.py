"""What a loop leaves of a disturbance in bands of frequency."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.metrics import kept
from frictionloop.loop.open_loop import steady_of
from frictionloop.quantities import FrictionloopError

LEAST = 0.01
"""Share of a disturbance (rms) below which a band of it is hardly there (chosen)."""


def in_band(values: np.ndarray, time_s: np.ndarray, low_hz: float, high_hz: float) -> np.ndarray:
    """Return the part of a signal above one frequency, up to another; what does not change is below all above 0.

    By a discrete Fourier transform of what is left without the line from the first to the last value, which counts
    below all frequencies.
    """
    line = np.linspace(values[0], values[-1], values.size)
    spectrum = np.fft.rfft(values - line)
    frequency_hz = np.fft.rfftfreq(values.size, time_s[1] - time_s[0])
    spectrum[(frequency_hz > high_hz) | ((frequency_hz <= low_hz) & (low_hz > 0))] = 0.0
    return np.asarray(np.fft.irfft(spectrum, values.size) + (line if low_hz == 0 else 0.0))


def disturbance_left_by_band(run: xr.Dataset, edges_hz: Sequence[float], mask: Any = None) -> xr.DataArray:
    """Return what `disturbance_left` is in each band of frequency, shape (band,).

        rms(band of f_a - f_a with d = mean(d)) / rms(band of d)

    Both signals are split over the whole run and scored as all else, so reversals, where a finger turns, spread over
    the bands. NaN for a band that holds less than 1 % (rms) of the disturbance, and for all where `disturbance_left`
    is NaN.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``.
    edges_hz : sequence of float
        Frequencies between bands in Hz, rising: ``[0, 4, 20, 100]`` are three bands. From 0 on what does not change
        counts too.
    mask : array of bool, optional
        The control periods to score, shape (time,), in place of those that are ``scored``.

    Raises
    ------
    FrictionloopError
        For edges that do not rise, or are below 0; for what is no run.
    """
    edges = np.asarray(edges_hz, dtype=float)
    if edges.ndim != 1 or edges.size < 2 or edges[0] < 0 or not np.all(np.diff(edges) > 0):
        raise FrictionloopError(f"edges_hz = {edges_hz!r}: must rise from 0 or above, as [0, 4, 20, 100]")
    keep = kept(run, mask)
    calm = steady_of(run, mask)
    share = np.full(edges.size - 1, np.nan)
    if calm is not None:
        time_s, d = run["time"].values, run["d"].values
        left = run["f_a"].values - calm["f_a"].values
        least_n = LEAST * float(np.std(d[keep]))
        for k, band in enumerate(itertools.pairwise(edges)):
            of, remains = (in_band(values, time_s, *band)[keep] for values in (d - d[keep].mean(), left))
            share[k] = _rms(remains) / _rms(of) if _rms(of) > least_n else np.nan
    ends = {"low_hz": ("band", edges[:-1]), "high_hz": ("band", edges[1:])}
    return xr.DataArray(share, dims="band", coords=ends, name="disturbance_left", attrs={"units": "1"})


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
