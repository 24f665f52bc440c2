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


TAPERED = 0.2
"""Share of the time in which the window rises and falls, both together (chosen)."""


def rms_by_band(values: np.ndarray, time_s: np.ndarray, keep: Any, edges_hz: Sequence[float]) -> np.ndarray:
    """Return the rms of a signal about its mean in bands of frequency, shape (bands,), in the signal's unit.

    It is that of a periodogram without its bin at 0 Hz, from the first period that counts to the last, behind a window
    that rises and falls over a tenth at each end (Tukey), whose power is made up for. So neither the moment at which a
    loop starts, nor a trend or a jump from the last to the first value, spreads over the bands. Squares of all bands
    add up to that of the windowed signal: what is there at an end alone counts less. Across periods that do not count,
    as reversals, stands a straight line.
    """
    from scipy.signal import periodogram  # takes long to load

    at = time_s[keep]
    inside = time_s[(time_s >= at[0]) & (time_s <= at[-1])]
    frequency_hz, density = periodogram(
        np.interp(inside, at, values[keep]),
        1.0 / (time_s[1] - time_s[0]),
        window=("tukey", TAPERED),
        detrend="constant",
    )
    power = density * frequency_hz[1]
    bands = [(frequency_hz > low) & (frequency_hz <= high) for low, high in itertools.pairwise(edges_hz)]
    return np.sqrt([power[band].sum() for band in bands])


def disturbance_left_by_band(run: xr.Dataset, edges_hz: Sequence[float], mask: Any = None) -> xr.DataArray:
    """Return what `disturbance_left` is in each band of frequency, shape (band,).

        rms(band of f_a - f_a with d = mean(d)) / rms(band of d)

    Both are those of a periodogram about the mean over the periods that count, behind a window that rises and falls
    over a tenth at each end (Tukey); across periods that do not count stands a straight line. They are beside the share
    as ``left_n`` and ``disturbance_n`` in N. The resolution is some two over the duration: bands that are narrower
    share what is in them. NaN for a band that holds less than 1 % (rms) of the
    disturbance, and for all where `disturbance_left` is NaN.

    Parameters
    ----------
    run : xarray.Dataset
        From ``simulate`` or ``load``.
    edges_hz : sequence of float
        Frequencies between bands in Hz, rising: ``[0, 4, 20, 100]`` are three bands.
    mask : array of bool, optional
        The control periods to score, shape (time,), in place of those that are ``scored``.

    Raises
    ------
    FrictionloopError
        For edges that do not rise, or are below 0; for what is no run.
    """
    edges = np.asarray(edges_hz, dtype=float)
    if edges.ndim != 1 or edges.size < 2 or edges[0] < 0 or not np.all(np.diff(edges) > 0):
        raise FrictionloopError(f"edges_hz = {edges_hz}: must rise, from at least 0")
    keep, calm = kept(run, mask), steady_of(run, mask)
    share, of, left = np.full((3, edges.size - 1), np.nan)
    if calm is not None:
        time_s, d = run["time"].values, run["d"].values
        of, left = (
            rms_by_band(each, time_s, keep, edges.tolist()) for each in (d, run["f_a"].values - calm["f_a"].values)
        )
        there = of > LEAST * float(np.std(d[keep]))
        share[there] = left[there] / of[there]
    ends = {"low_hz": ("band", edges[:-1]), "high_hz": ("band", edges[1:])}
    ends |= {"disturbance_n": ("band", of), "left_n": ("band", left)}
    return xr.DataArray(share, dims="band", coords=ends, name="disturbance_left", attrs={"units": "1"})
