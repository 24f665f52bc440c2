"""What no linear controller gets below that bears a resonance that is off, finger by finger."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from joblib import Parallel, delayed

from frictionloop.analysis.linear import linearise
from frictionloop.analysis.sampled import SampledPlant
from frictionloop.analysis.state_space import Complex
from frictionloop.parameters import System
from studies.causes import mean_occlusion
from studies.friction_spectrum import disturbed_levels, own_systems
from studies.linear_reach import CALM, LEVELS_N, reading_noise_psd, way_n
from studies.robust_optimum import robust_optimum
from studies.wiener_hopf import bins

UNMEASURED: Mapping[float, float] = {0.0: 1.7, 0.05: 2.0, 0.1: 2.6}
"""Largest |S| by how far the resonance is off, relative, to either side: what is asked of a law that is told the
bench's resonance, not that of its own device."""
BINS = 2**12
"""Bins of the FFT: 0.6 Hz at 5 kHz; for 11 s the bound is up to 1 % or so above that of eight times as many."""


def robust_reach(
    system: System,
    fingers: Sequence[Mapping[str, Any]],
    duration_s: float = 11.0,
    seed: int = 0,
    *,
    score_from_s: float = 1.0,
    limits: Mapping[float, float] = UNMEASURED,
    levels_n: Sequence[float] = LEVELS_N,
) -> xr.Dataset:
    """Return the bound of `robust_optimum` for each finger on its own plant, its drive spared.

    Disturbance, noise and plant are those of `linear_reach`, force and load measured; a controller knows all of them,
    and the finger's own resonance. It has to keep the peaks of |S| where the resonance is that of ``system`` and off by
    ``limits``. No linear controller that does leaves less, on average over the stroke.

    Parameters
    ----------
    system, fingers, duration_s, seed, score_from_s, levels_n
        As for `linear_reach`; the sensor is a "suspended" one. Fingers may bring a resonance of their own.
    limits : mapping
        Largest |S| by how far the resonance is off to either side, relative; each above 1. `UNMEASURED` if
        not given.

    Returns
    -------
    xarray.Dataset
        ``bound_rms_n`` (N) over ``finger``; squares are averaged over levels. NaN for who cannot be given one of them.
    """
    peaks = {side * off: peak for off, peak in limits.items() for side in (1.0, -1.0)}
    sensor: Any = system.sensor
    met = {sensor.resonance_hz * (1.0 + off): peak for off, peak in peaks.items()}
    asked = duration_s, seed, score_from_s, tuple(levels_n), met
    found = Parallel(n_jobs=-1)(delayed(_bound)(own, *asked) for own in own_systems(system, fingers))
    about = "rms of f_a - f_r that no linear controller that bears these resonances gets below"
    return xr.Dataset({"bound_rms_n": ("finger", np.array(found), {"units": "N", "long_name": about})})


def _bound(
    system: System,
    duration_s: float,
    seed: int,
    score_from_s: float,
    levels: Sequence[float],
    met: Mapping[float, float],
) -> float:
    found = disturbed_levels(system, duration_s, seed, score_from_s, levels)
    if found is None:
        return math.nan
    occluded, square = mean_occlusion(system, score_from_s, duration_s), 0.0
    for level, (loop, frequency_hz, psds) in zip(levels, found, strict=True):
        friction, reading = loop.plant.numerators()
        size = float(np.max(np.abs(reading)))
        paths = tuple(path / size for path in (reading, friction, np.poly(loop.plant.transition)))
        noise = reading_noise_psd(system, frequency_hz)
        spectra = bins(frequency_hz, psds[-1], noise, loop.nyquist_hz, paths, BINS)  # type: ignore[arg-type]
        others = [
            linearise(system.evolve({"sensor.resonance_hz": hertz}), force_n=level, occluded=occluded) for hertz in met
        ]
        own = _reading(loop.plant)
        ratios = np.array([_reading(each.plant) / own for each in others])
        calm_n = CALM * way_n(system, occluded, level)
        square += robust_optimum(spectra, ratios, np.array(list(met.values())), calm_n).bound_rms_n ** 2
    return math.sqrt(square / len(levels))


def _reading(plant: SampledPlant) -> Complex:
    """Return the response from command to reading at the bins."""
    back = np.exp(-1j * np.pi * np.arange(BINS + 1) / BINS)
    _, reading = plant.numerators()
    polynomial = np.polynomial.polynomial.polyval
    return np.asarray(polynomial(back, reading) / polynomial(back, np.poly(plant.transition)))
