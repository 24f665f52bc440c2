"""What a loop leaves of a disturbance in the bands of frequency that it is given."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from frictionloop.loop.companion_runs import steady_of
from frictionloop.loop.metrics import counted
from frictionloop.quantities import must_be

if TYPE_CHECKING:
    import xarray as xr

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
        raise must_be("edges_hz", edges_hz, "2 or more rising, none below 0")
    keep, calm = counted(run, mask), steady_of(run, mask)
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
    import xarray as xr

    return xr.DataArray(share, dims="band", coords=ends, name="disturbance_left", attrs={"units": "1"})


class Band(NamedTuple):
    """A band of frequency of the disturbance."""

    low_hz: float
    high_hz: float
    disturbance_n: float
    """What the disturbance varies by there, rms."""
    left_n: float
    """What is left of it."""
    disturbance_left: float
    """Share that is left; NaN where next to nothing varies."""


def split_edges(split_hz: Sequence[float], rate_hz: float) -> list[float]:
    """Return the ends of the bands in Hz, from 0 to infinity; none where no frequency is given.

    Raises
    ------
    FrictionloopError
        For frequencies that do not rise from above 0 to below half the loop's rate.
    """
    if not len(split_hz):
        return []
    named = [float(each) for each in split_hz]
    if not all(low < high for low, high in itertools.pairwise([0.0, *named, rate_hz / 2.0])):
        said = ",".join(f"{each:g}" for each in named)
        raise must_be("split_hz", said, f"rising, above 0 and below {rate_hz / 2.0:g}", "Hz")
    return [0.0, *named, math.inf]


def by_band(run: xr.Dataset, mask: np.ndarray, edges_hz: Sequence[float]) -> tuple[Band, ...]:
    """Return each band with what varies in it and what is left."""
    if not edges_hz or not mask.any():
        return ()
    found = disturbance_left_by_band(run, edges_hz, mask)
    columns = [found[each].values.tolist() for each in ("low_hz", "high_hz", "disturbance_n", "left_n")]
    return tuple(Band(*row) for row in zip(*columns, found.values.tolist(), strict=True))
