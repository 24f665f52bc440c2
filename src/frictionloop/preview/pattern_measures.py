"""How much of a pattern is in a run: its contrast, how far it is moved, what is left of error."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from frictionloop.loop.companion_runs import felt_trace
from frictionloop.loop.record import system_of
from frictionloop.parameters import Strokes
from frictionloop.quantities import Array

LATEST_S, LAGS = 0.03, 76
"""Longest delay that a pattern is looked for at, and the delays that are tried (assumed: 30 ms, 0.4 ms apart)."""
LEAST_N = 1e-3
"""Standard deviation below which an effect has no contrast (assumed)."""
FELT_S = 0.05
"""Time around a place in which what is felt there is added up (assumed)."""
CELLS = 400
"""Stretches of a stroke that forces are averaged in."""


class Delivered(NamedTuple):
    """What reaches the finger under one law."""

    law: str
    contrast: float
    """Slope of the force on the finger over the intended one, at the delay where they agree best; NaN for a level."""
    moved_mm: float
    """How far the pattern is felt behind its place: that delay times the speed."""
    rms_error_n: float
    """Of the force on the finger against the intended one, delay included, N rms."""
    mean_error_n: float
    """Mean of the same."""
    error_felt: float
    """Index D of the same: felt above 1."""
    pattern_felt: float
    """Index D of the part of the force that is the pattern: the intended variation times the contrast."""
    pattern_over: Array
    """The pattern in thresholds of touch over place, rms over 50 ms and both ways, shape (cells,)."""
    error_over: Array
    """The error in the same, over place."""
    forth_n: Array
    """Mean force over place on the way forth, shape (cells,); NaN where it never counted."""
    back_n: Array
    """The same on the way back."""

    @property
    def share_felt(self) -> float:
        """Share of the path on which the pattern is above the threshold of touch."""
        known = np.isfinite(self.pattern_over)
        return float(np.mean(self.pattern_over[known] > 1.0))

    @property
    def over_n(self) -> Array:
        """Mean of both ways."""
        return np.asarray(0.5 * (self.forth_n + self.back_n))


def edges_mm(motion: Strokes) -> Array:
    """Return the edges of the stretches that a stroke is cut in."""
    return np.linspace(-0.5 * motion.stroke_mm, 0.5 * motion.stroke_mm, CELLS + 1)


def delivered(run: xr.Dataset, law: str) -> Delivered:
    """Return what of its effect is in a run."""
    system, keep = system_of(run), run["scored"].values
    assert isinstance(system.motion, Strokes)
    wanted, force = run["f_r_intended"].values, run["f_a"].values
    contrast, delay = slope_of(wanted, force, keep, system.controller.rate_hz)
    error = (force - wanted)[keep]
    ways = [over_place(run, "f_a", way) for way in (1.0, -1.0)]
    varied = wanted - wanted[keep].mean()
    given = contrast if math.isfinite(contrast) else 1.0
    return Delivered(
        law,
        contrast,
        delay * system.motion.speed_mm_s,
        math.sqrt(float(np.mean(error**2))),
        float(np.mean(error)),
        felt(run, force - wanted),
        felt(run, varied) * given,
        felt_over(run, varied) * given,
        felt_over(run, force - wanted),
        *ways,
    )


def felt(run: xr.Dataset, force_n: Array) -> float:
    """Return the index D of a force along a run."""
    weighted, scored = felt_trace(force_n, run)
    return float(np.sqrt(np.sum(weighted**2) / np.sum(scored)))


def felt_over(run: xr.Dataset, force_n: Array) -> Array:
    """Return the same over place: the rms of what is felt around each time, mean of both ways, shape (cells,)."""
    weighted, scored = felt_trace(force_n, run)
    size = round(FELT_S * system_of(run).controller.rate_hz)
    squares, counts = (uniform_filter1d(each, size, mode="constant") for each in (weighted**2, scored))
    around = run.assign(felt=("time", squares / np.maximum(counts, 1e-9)))
    power = np.array([over_place(around, "felt", way) for way in (1.0, -1.0)])
    known = np.isfinite(power)
    mean = np.where(known, power, 0.0).sum(0) / np.maximum(known.sum(0), 1)
    return np.where(known.any(0), np.sqrt(np.maximum(mean, 0.0)), np.nan)


def slope_of(wanted: Array, force: Array, keep: NDArray[np.bool_], rate_hz: float) -> tuple[float, float]:
    """Return the slope of the force over what was intended, and the delay in s at which they correlate best.

    Of a wave it is the share at the pattern's own period, |F| / |W|: what else is in the force does not count. It is
    NaN where what is intended does not vary.
    """
    if np.std(wanted[keep]) < LEAST_N:
        return math.nan, 0.0
    wanted, force = (np.where(keep, each, 0.0) for each in (wanted, force))  # a device does not know all
    late = np.unique(np.round(np.linspace(0.0, LATEST_S, LAGS) * rate_hz).astype(int))
    late = late[late < keep.size]
    mask = keep.astype(float)
    r, f = mask * (wanted - wanted[keep].mean()), mask * (force - force[keep].mean())
    # Sums over the periods that count both now and a delay later, for all delays at once.
    size = 1 << (keep.size + int(late[-1])).bit_length()
    mask_w, r_w, rr_w, f_w, ff_w = (np.fft.rfft(each, size) for each in (mask, r, r * r, f, f * f))

    def summed(earlier: Any, later: Any) -> Array:
        return np.asarray(np.fft.irfft(np.conj(earlier) * later, size)[late])

    count = np.maximum(summed(mask_w, mask_w), 1.0)
    r_sum, f_sum = summed(r_w, mask_w), summed(mask_w, f_w)
    both = summed(r_w, f_w) - r_sum * f_sum / count
    spreads = summed(rr_w, mask_w) - r_sum**2 / count, summed(mask_w, ff_w) - f_sum**2 / count
    r_spread, f_spread = (np.maximum(each, 1e-30) for each in spreads)
    best = int(np.argmax(both / np.sqrt(r_spread * f_spread)))
    return float(both[best] / r_spread[best]), float(late[best]) / rate_hz


def over_place(run: xr.Dataset, name: str, way: float) -> Array:
    """Return the mean of a trace over place on the way forth (1) or back (-1), where it counts."""
    motion = system_of(run).motion
    assert isinstance(motion, Strokes)
    x, v, keep = 1e3 * run["position"].values, run["speed"].values, run["scored"].values
    cell = np.digitize(x, edges_mm(motion)) - 1
    keep = keep & (v * way > 0.0) & (cell >= 0) & (cell < CELLS)
    count = np.bincount(cell[keep], minlength=CELLS)
    total = np.bincount(cell[keep], weights=run[name].values[keep], minlength=CELLS)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
