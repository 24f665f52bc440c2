"""Fidelity over the gains, as in the paper's Fig. 2a: maps, cuts, their optimum and the useful range around it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System
from frictionloop.report.tolerances import R2_STEP

KP, KI = "controller.kp", "controller.ki"
R20 = (1, 1.12, 1.25, 1.4, 1.6, 1.8, 2, 2.24, 2.5, 2.8, 3.15, 3.55, 4, 4.5, 5, 5.6, 6.3, 7.1, 8, 9)
"""Preferred numbers of a decade, twelve per cent apart (ISO 3)."""
KPS = np.array([0.63, 0.71, 0.8, 0.9, *R20, *np.multiply(R20, 10), 100])
"""Proportional gains, N/N."""
KIS = np.array([digits * decade for decade in (0.1, 1, 10, 100, 1e3, 1e4) for digits in R20[::2]] + [1e5])
"""Integral gains, 1/s; a map goes up to 10^4."""
SEEDS = 4
DURATION_S = 10.0


def fidelity_map(system: System, seeds: int = 2) -> xr.Dataset:
    """Return the median r2_identity over ``kp`` and ``ki``, and r2_bound."""
    found = sweep(
        system, {KP: KPS, KI: KIS[KIS <= 1e4]}, DURATION_S, seeds, ["r2_identity", "r2_bound"], progress=False
    ).median("seed")
    bound = found["r2_bound"].max()
    return xr.Dataset({"r2_identity": found["r2_identity"], "r2_bound": bound}).rename({KP: "kp", KI: "ki"})


def fidelity_over(system: System, path: str, values: np.ndarray = KPS) -> xr.Dataset:
    """Return r2_identity and saturation_index (medians over seeds) over one gain (dim ``gain``), and r2_bound."""
    names = ["r2_identity", "saturation_index", "r2_bound"]
    found = sweep(system, {path: values}, DURATION_S, SEEDS, names, progress=False).median("seed")
    return found.assign(r2_bound=found["r2_bound"].max()).rename({path: "gain"})


class Optimum(NamedTuple):
    """The best point of a cut or a map, and its fidelity."""

    kp: float
    ki: float
    r2: float


def optimum(fidelity: xr.DataArray, ki: float = 2.0) -> Optimum:
    """Return where fidelity over ``gain`` (then at this ``ki``) or over ``kp`` and ``ki`` is largest."""
    best = fidelity.isel(fidelity.argmax(...))
    if "gain" in best.coords:
        return Optimum(float(best["gain"]), ki, float(best))
    return Optimum(float(best["kp"]), float(best["ki"]), float(best))


class Range(NamedTuple):
    """A range of gains; an end is None where the sweep ends before the range does."""

    low: float | None
    high: float | None


def middle(found: Range) -> float | None:
    """Return the middle of a range by ratio; None where an end is missing.

    >>> middle(Range(5.0, 20.0)), middle(Range(5.0, None))
    (10.0, None)
    """
    return None if found.low is None or found.high is None else math.sqrt(found.low * found.high)


def useful_range(fidelity: xr.DataArray, step: float = R2_STEP) -> Range:
    """Return the gains around the best one with r2 within ``step`` of it, interpolated over the gain's logarithm."""
    gain, margin = np.log(fidelity["gain"].values), fidelity.values - float(fidelity.max()) + step
    best = int(np.argmax(margin))
    above = next((i for i in range(best, len(gain)) if margin[i] < 0), None)
    below = next((i for i in range(best, -1, -1) if margin[i] < 0), None)
    return Range(
        low=None if below is None else _zero(gain, margin, below, below + 1),
        high=None if above is None else _zero(gain, margin, above - 1, above),
    )


def _zero(x: np.ndarray, y: np.ndarray, i: int, j: int) -> float:
    """Return exp(x) where the line through points i and j crosses zero."""
    return math.exp(float(x[i] - y[i] * (x[j] - x[i]) / (y[j] - y[i])))


def at(fidelity: xr.DataArray, gain: float) -> float:
    """Return the fidelity at the gain of the sweep that is nearest to ``gain``."""
    return float(fidelity.sel(gain=gain, method="nearest"))


def spread(fidelity: xr.DataArray, low: float, high: float) -> float:
    """Return the largest minus the smallest fidelity for gains from ``low`` to ``high``."""
    within = fidelity.where((fidelity["gain"] >= low * (1 - 1e-9)) & (fidelity["gain"] <= high * (1 + 1e-9)), drop=True)
    return float(within.max() - within.min())
