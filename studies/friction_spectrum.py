"""What the friction of a finger does on a plain stroke, as a spectrum, with a measured load fed forward or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.loop_elements import linearise_contact
from frictionloop.loop.companion_runs import plain_stroke
from frictionloop.parameters import System
from frictionloop.quantities import Array, FrictionloopError
from studies.causes import mean_occlusion
from studies.residual_bands import stretches

MEASURED = ("force", "force and load")
"""What a controller measures; the load, if it does, it feeds forward."""
SEGMENT_S = 2.0
"""Longest segment of Welch's estimate: several to a run of 10 s, and tremor still resolved."""
PER_OCTAVE = 16
"""Bands per octave that the estimate is averaged over: its scatter would count as valleys to hide |S| in."""


def disturbed_levels(
    system: System, duration_s: float, seed: int, score_from_s: float, levels_n: Sequence[float]
) -> list[tuple[LinearLoop, Array, tuple[Array, ...]]] | None:
    """Return for each level the plant, frequencies in Hz, and the disturbance in N^2/Hz for each of `MEASURED`.

    Around a force F friction moves by F d(ln Fmax), with Fmax(t) the friction limit of a stroke without vibration:
    its density is F^2 times Welch's estimate over the scored stretches. A measured load, fed forward at once and
    without error, takes n ln N out of ln Fmax (n the exponent of the load): the best case. The contact passes it on
    with its own lag, of its slip length. None if a level is out of this finger's reach.
    """
    frequency_hz, densities = log_limit_psd(system, duration_s, seed, score_from_s)
    occluded = mean_occlusion(system, score_from_s, duration_s)
    found = []
    for force_n in levels_n:
        try:
            loop = linearise(system, force_n=force_n, occluded=occluded)
        except FrictionloopError:
            return None
        lag = np.abs(linearise_contact(system, force_n).response(frequency_hz)) ** 2
        found.append((loop, frequency_hz, tuple(force_n**2 * lag * density for density in densities)))
    return found


def own_systems(system: System, fingers: Sequence[Mapping[str, Any]]) -> list[System]:
    """Return the system of each finger, under a lookup: its plant is what counts."""
    return [system.evolve({**each, "controller.kind": "lookup"}) for each in fingers]


def power_of(frequency_hz: Array, psd: Array, nyquist_hz: float) -> float:
    """Return the integral of a density whose frequencies stand for bands as in `waterbed_bound`."""
    edges = np.concatenate([[0.0], (frequency_hz[1:] + frequency_hz[:-1]) / 2, [nyquist_hz]])
    return float(np.diff(edges) @ psd)


def log_limit_psd(
    system: System, duration_s: float, seed: int, score_from_s: float
) -> tuple[Array, tuple[Array, Array]]:
    """Return frequencies in Hz and densities in 1/Hz of ln Fmax of a plain stroke, with and without n ln N in it."""
    run, rate_hz = plain_stroke(system, 0.0, duration_s, seed), system.controller.rate_hz
    scored = run["scored"].values & (run["time"].values >= score_from_s - 0.5 / rate_hz)
    load = system.friction.load_exponent * np.log(np.where(scored, run["load"].values, 1.0))  # type: ignore[attr-defined]
    whole = np.log(np.where(scored, run["limit"].values, 1.0))
    parts = stretches(scored)
    (frequency_hz, left_in), (_, fed) = (stretch_psd(each, parts, rate_hz) for each in (whole, whole - load))
    return frequency_hz, (left_in, fed)


def stretch_psd(signal: Array, parts: Sequence[Array], rate_hz: float) -> tuple[Array, Array]:
    """Return Welch's one-sided density of several stretches, averaged in bands of 1/16 octave, above 0 Hz.

    Each segment loses its straight line, so what is slower than a segment is left out of the density.
    """
    from scipy.signal import welch

    longest = max((part.size for part in parts), default=0)
    size = min(round(SEGMENT_S * rate_hz), longest)
    used = [part for part in parts if part.size >= max(size, 2)]
    if not used:
        raise FrictionloopError("a finger is never scored: duration_s or motion.stroke_mm is too short")
    options = {"fs": rate_hz, "nperseg": size, "detrend": "linear"}
    found = [welch(signal[part], **options) for part in used]
    density = np.average([each for _, each in found], axis=0, weights=[part.size for part in used])
    return _smoothed(found[0][0][1:], density[1:])


def _smoothed(frequency_hz: Array, density: Array) -> tuple[Array, Array]:
    band = np.floor(PER_OCTAVE * np.log2(frequency_hz / frequency_hz[0]) + 1e-9).astype(int)
    _, index, counts = np.unique(band, return_inverse=True, return_counts=True)
    return tuple(np.bincount(index, each) / counts for each in (frequency_hz, density))  # type: ignore[return-value]
