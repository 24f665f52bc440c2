"""What a controller has to fight: the spectrum of the friction force at an operating point, and a filter that makes it.

Identified, not assumed: plain strokes under a constant amplitude give the fluctuation of the force, Welch
its spectrum, and a fit of low order (SLICOT's SB10YD) the filter that a synthesis takes as its weight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from frictionloop.analysis.operating_point import force_band, operating_amplitude_um, reach_at
from frictionloop.design.slicot import Quadruple, slicot
from frictionloop.loop.companion_runs import plain_stroke
from frictionloop.parameters import Strokes, System, check_system
from frictionloop.quantities import Array, FrictionloopError

RUN_S = 12.0
"""Length of each run."""
SEGMENT_S = 2.0
"""Longest Welch segment: 1 Hz between zeros of the Hann window's main lobe, enough for a tremor 4 Hz wide."""
SHORTEST_S = 0.2
"""Shortest stretch of a stroke that is looked at: below it a tremor's peak blurs."""
STATES = 5
"""Of the filter: a peak, and 1/f to about 1 dB."""
PER_DECADE = 20
"""Points of the spectrum per decade in the fit, so that high frequencies, which have more lines, do not rule it."""
HIGHEST_HZ = 200.0
"""Frequency up to which the fit looks: with 300 us of delay no loop attenuates above it, and it only matters as |S|."""


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """The disturbance of a loop, in newtons."""

    spectrum: xr.DataArray
    """One-sided density of the friction force's fluctuation, N^2/Hz over ``frequency`` (Hz)."""
    shaping: Quadruple
    """H(s) with |H(j 2 pi f)|^2 the fitted one-sided density: white noise of 1/Hz, one-sided, through it is d."""

    def density(self, frequency_hz: ArrayLike) -> Array:
        """Return the fitted one-sided density in N^2/Hz."""
        return np.abs(self.shaping.at(2j * np.pi * np.asarray(frequency_hz, dtype=float))[:, 0, 0]) ** 2


def identify_noise(system: System, seeds: Sequence[int] = (0, 1, 2, 3)) -> NoiseModel:
    """Return the disturbance at the mean force asked for, or the nearest in reach, from simulated plain strokes.

    Parameters
    ----------
    system
        The loop, with a finger that strokes.
    seeds
        Seeds of the runs, at least one; one spectrum is averaged over all.

    Raises
    ------
    FrictionloopError
        A system without strokes, no seed, or runs without a stretch of sliding of 0.2 s.
    """
    check_system(system)
    if not isinstance(system.motion, Strokes):
        raise FrictionloopError(f"motion.kind = {system.motion.kind!r}: must be 'strokes'")
    if not len(seeds):
        raise FrictionloopError("seeds = []: needs one")
    force = float(reach_at(system).nearest(force_band(system).mean_n))
    amplitude = operating_amplitude_um(system, 0.0, None, force)
    stretches = [part for seed in seeds for part in _stretches(plain_stroke(system, amplitude, RUN_S, seed))]
    spectrum = _spectrum(stretches, system.controller.rate_hz)
    return NoiseModel(spectrum, fit_shaping(spectrum["frequency"].values, spectrum.values))


def fit_shaping(frequency_hz: Array, density: Array) -> Quadruple:
    """Return the stable filter of minimum phase whose |H(j 2 pi f)|^2 is nearest to a one-sided density, up to 200 Hz.

    Parameters
    ----------
    frequency_hz
        Rising frequencies in Hz, above 0.
    density
        One-sided density, above 0, unit^2/Hz.

    Raises
    ------
    FrictionloopError
        A density that is not positive and finite, fewer than 12 frequencies below 200 Hz, or no filter.
    """
    inside = frequency_hz <= HIGHEST_HZ
    if inside.sum() < 12 or not np.all(np.isfinite(density[inside]) & (density[inside] > 0)):
        raise FrictionloopError("density: needs 12 values above 0")
    f, level = _thinned(frequency_hz[inside], density[inside])
    gain, phase = np.sqrt(level), np.zeros(f.size)  # of the minimum phase, which SLICOT finds
    A, B, C, D, _, info = slicot().sb10yd(0, 1, STATES, gain, phase, 2 * math.pi * f, 1e-9)
    if info:
        raise FrictionloopError(f"noise spectrum: no fit (SLICOT {info})")
    return Quadruple(A, B[:, None], C[None, :], np.array([[D]]))


def _thinned(frequency: Array, density: Array) -> tuple[Array, Array]:
    """Return means over equal steps of log f."""
    decades = math.log10(frequency[-1] / frequency[0])
    edges = np.geomspace(frequency[0], frequency[-1] * (1 + 1e-9), math.ceil(PER_DECADE * decades) + 1)
    which = np.digitize(frequency, edges)
    groups = [which == k for k in np.unique(which)]
    return np.array([frequency[g].mean() for g in groups]), np.array([density[g].mean() for g in groups])


def _stretches(run: xr.Dataset) -> list[Array]:
    """Return the force of every scored stretch: one stroke each, without its reversals."""
    keep, force = run["scored"].values.astype(bool), run["f_a"].values
    edges = np.flatnonzero(np.diff(keep.astype(int))) + 1
    return [part for part, kept in zip(np.split(force, edges), np.split(keep, edges), strict=True) if kept.all()]


def _spectrum(stretches: Sequence[Array], rate_hz: float) -> xr.DataArray:
    from scipy.signal import welch

    longest = max((part.size for part in stretches), default=0)
    segment = min(round(SEGMENT_S * rate_hz), longest)
    if segment < SHORTEST_S * rate_hz:
        raise FrictionloopError(f"strokes: {longest / rate_hz:g} s of steady sliding, least {SHORTEST_S:g} s")
    long_enough = [part for part in stretches if part.size >= segment]
    found = [welch(part, rate_hz, nperseg=segment, detrend="linear") for part in long_enough]
    # A straight line taken out leaves nothing to see in the two lowest bins of a Hann window.
    frequency, density = found[0][0][2:], np.mean([psd for _, psd in found], axis=0)[2:]
    return xr.DataArray(
        density,
        {"frequency": ("frequency", frequency, {"units": "Hz"})},
        name="friction_noise",
        attrs={"units": "N^2/Hz", "long_name": "fluctuation of the friction force", "stretches": len(long_enough)},
    )
