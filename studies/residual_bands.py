"""The residual split by frequency: bands whose squares add up to the whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from joblib import Parallel, delayed
from scipy.fft import dct

from frictionloop.loop.simulate import simulate
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError

EDGES_HZ = (5.0, 15.0, 60.0, 250.0)
"""Set-point and drift, tremor, what the loop follows, the sensor's resonance and the loop's crossover, beyond."""


def residual_bands(
    system: System,
    fingers: Sequence[Mapping[str, Any]] | None = None,
    duration_s: float = 11.0,
    seed: int = 0,
    *,
    score_from_s: float = 1.0,
    edges_hz: Sequence[float] = EDGES_HZ,
) -> xr.Dataset:
    """Return the rms of f_a - f_r in bands of frequency, from one run of each finger.

    Returns
    -------
    xarray.Dataset
        In N: ``rms`` over ``band`` and ``finger``, ``all`` over ``finger``; coordinates ``low_hz`` and ``high_hz``.
    """
    edges = np.asarray(edges_hz, dtype=float)
    owns = [system.evolve(each) for each in (fingers if fingers is not None else [{}])]
    parallel = Parallel(n_jobs=-1, prefer="threads")
    found = np.array(parallel(delayed(_bands)(own, duration_s, seed, score_from_s, edges) for own in owns))
    about = {"units": "N", "long_name": "rms of f_a - f_r"}
    whole = np.sqrt(np.sum(found**2, axis=1))
    bounds = np.array([0.0, *edges, system.controller.rate_hz / 2])
    coordinates = {"low_hz": ("band", bounds[:-1], {"units": "Hz"}), "high_hz": ("band", bounds[1:], {"units": "Hz"})}
    return xr.Dataset({"rms": (("band", "finger"), found.T, about), "all": ("finger", whole, about)}, coordinates)


def _bands(system: System, duration_s: float, seed: int, score_from_s: float, edges: np.ndarray) -> np.ndarray:
    run, rate_hz = simulate(system, duration_s, seed), system.controller.rate_hz
    scored = run["time"].values >= score_from_s - 0.5 / rate_hz
    if "scored" in run:
        scored &= run["scored"].values
    return band_rms(run["f_a"].values - run["f_r"].values, scored, rate_hz, edges)


def stretches(scored: np.ndarray) -> list[np.ndarray]:
    """Return the indices of each unbroken stretch that is scored."""
    parts = np.split(np.arange(scored.size), np.flatnonzero(np.diff(scored)) + 1)
    return [part for part in parts if part.size and scored[part[0]]]


def band_rms(residual: np.ndarray, scored: np.ndarray, rate_hz: float, edges_hz: np.ndarray) -> np.ndarray:
    """Return the rms in each band, of all scored periods, shape (bands,).

    By a cosine transform of each stretch: it keeps the sum of squares (Parseval), and as it continues a stretch by its
    mirror image, ends that do not meet leak little into other bands.
    """
    squares, count = np.zeros(len(edges_hz) + 1), 0
    for part in stretches(scored):
        amplitude = dct(residual[part], norm="ortho")
        frequency_hz = np.arange(part.size) * (0.5 * rate_hz / part.size)
        squares += np.bincount(np.searchsorted(edges_hz, frequency_hz, side="right"), amplitude**2, squares.size)
        count += part.size
    if not count:
        raise FrictionloopError("residual_bands: a finger is never scored")
    return np.asarray(np.sqrt(squares / count))
