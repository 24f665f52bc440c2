"""How little of a finger's friction noise any linear controller lets touch feel, and what that costs in rms.

``python -m studies.felt_reach`` keeps rms and index of the first ninety capable fingers for each weight, the table of
*pages/limits-of-control.md*, "How little of it can be felt": some minutes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from joblib import Parallel, delayed
from scipy.signal import sosfreqz

from frictionloop.design.comparison import trial_protocol
from frictionloop.parameters import System
from frictionloop.perception.weighting import weighting_sos
from frictionloop.quantities import Array
from studies.conditions import conditions
from studies.friction_spectrum import disturbed_levels, own_systems
from studies.kept import both, keep
from studies.linear_optimum import BINS, linear_optimum
from studies.linear_reach import LEVELS_N, reading_noise_psd
from studies.wiener_hopf import bins, squared

WEIGHTS = (0.0, 0.1, 0.3, 1.0)
REFERENCE_HZ = 100.0
"""Frequency at which a weight is told: there the power of a force counts 1 + weight times."""
KEPT = {
    "rms_n": ("N", "rms of f_a - f_r"),
    "relative_index": ("1", "index D of f_a - f_r, over that before any control"),
}


def felt_reach(
    system: System,
    fingers: Sequence[Mapping[str, Any]],
    weights: Sequence[float] = WEIGHTS,
    duration_s: float = 11.0,
    seed: int = 0,
    *,
    score_from_s: float = 1.0,
    sensitivity_peak: float = 1.7,
    levels_n: Sequence[float] = LEVELS_N,
) -> xr.Dataset:
    """Return rms and relative index of the linear controllers that leave least of both, weighed against each other.

    The index D is a weighted rms, D^2 = integral S(f) / F_th(f)^2 df, so what leaves the least of
    rms^2 + weight F_th(100 Hz)^2 D^2 is `linear_optimum` of disturbance and noise that are multiplied by
    1 + weight (F_th(100 Hz) / F_th(f))^2 (by the filter of `weighting_sos`). Weight 0 is the least rms, and no linear
    controller that keeps the peak has both less rms and a smaller index than the one of any weight. Plant, disturbance
    and what is left out of account are those of `linear_reach`, force and load measured, the drive never cut.

    Returns
    -------
    xarray.Dataset
        ``rms_n`` (N) and ``relative_index`` (1) over ``weight`` and ``finger``; squares are averaged over levels. NaN
        for a finger that cannot be given a level.
    """
    asked = tuple(weights), duration_s, seed, score_from_s, sensitivity_peak, tuple(levels_n)
    rows = Parallel(n_jobs=-1, prefer="threads")(delayed(_reach)(own, *asked) for own in own_systems(system, fingers))
    found = np.array(rows).reshape(len(rows), len(asked[0]), len(KEPT))
    return xr.Dataset(
        {
            name: (("weight", "finger"), found[..., k].T, {"units": unit, "long_name": about})
            for k, (name, (unit, about)) in enumerate(KEPT.items())
        },
        {"weight": list(asked[0])},
    )


def _felt_power(frequency_hz: Any, rate_hz: float) -> Array:
    """Return |H(f)|^2 of the filter of touch, 1/N^2; below 1200 Hz that of 1200 Hz: a gain needs none that runs."""
    rate = max(rate_hz, 1200.0)
    return np.abs(sosfreqz(weighting_sos(rate), frequency_hz, fs=rate)[1]) ** 2


def _reach(
    system: System,
    weights: Sequence[float],
    duration_s: float,
    seed: int,
    score_from_s: float,
    peak: float,
    levels: Sequence[float],
) -> Array:
    found = disturbed_levels(system, duration_s, seed, score_from_s, levels)
    if found is None:
        return np.full((len(weights), len(KEPT)), math.nan)
    sums, before = np.zeros((len(weights), len(KEPT))), 0.0
    for loop, frequency_hz, psds in found:
        friction, reading = loop.plant.numerators()
        noise, psd, rate_hz = reading_noise_psd(system, frequency_hz), psds[-1], 2.0 * loop.nyquist_hz
        spectra = bins(frequency_hz, psd, noise, loop.nyquist_hz, (reading, friction, (1.0,)), BINS)
        felt = _felt_power(np.linspace(0.0, loop.nyquist_hz, BINS + 1), rate_hz)
        before += float(spectra.width_hz @ (spectra.disturbance * felt))
        for k, weight in enumerate(weights):
            more = 1.0 + weight * _felt_power(frequency_hz, rate_hz) / _felt_power([REFERENCE_HZ], rate_hz)
            paths: dict[str, Any] = {"reading": reading, "friction": friction, "poles": np.poly(loop.plant.transition)}
            best = linear_optimum(frequency_hz, more * psd, more * noise, peak, loop.nyquist_hz, **paths)
            correction = (1.0 - best.sensitivity) / spectra.reading
            left = squared(best.sensitivity) * spectra.disturbance + squared(correction) * spectra.heard()
            sums[k] += spectra.width_hz @ left, spectra.width_hz @ (left * felt)
    return np.asarray(np.sqrt(sums / [len(levels), before]))


def main() -> None:
    """Keep medians and worst deciles for each speed, slip length and weight: mN, and D over that without control."""
    heads = ("mm/s", "um", *(f"{what}, {weight:g}" for weight in WEIGHTS for what in ("rms", "felt")))
    keep("felt-reach", "felt_reach", heads, rows())


def rows() -> Iterator[list[Any]]:
    """Yield what is kept of each speed and slip length."""
    for name, system, people in conditions():
        found = felt_reach(system, people[:90], seed=trial_protocol.EVALUATION_SEED)
        weighed = [found.sel(weight=weight) for weight in WEIGHTS]
        cells = [(both(1e3 * one["rms_n"].values), both(one["relative_index"].values, 2)) for one in weighed]
        yield [*name.split(" mm/s, "), *(cell for pair in cells for cell in pair)]


if __name__ == "__main__":
    main()
