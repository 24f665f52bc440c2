"""What a controller has to fight: the spectrum of the friction force at an operating point, and a filter that makes it.

Identified, not assumed: plain strokes under a constant amplitude (loop/felt) give the fluctuation of the force, Welch
its spectrum, and a fit of low order the shaping filter that a synthesis takes as its weight.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from frictionloop.analysis.operating import asked, law_at, operating_amplitude_um, reach_n
from frictionloop.analysis.state_space import Array
from frictionloop.design.shaping import fit_shaping
from frictionloop.loop.felt import plain_stroke
from frictionloop.parameters import LowpassSensor, Strokes, System, check_system
from frictionloop.quantities import FrictionloopError, Lti

RUN_S = 12.0
"""Length of each run."""
SEGMENT_S = 2.0
"""Longest Welch segment: 1 Hz between zeros of the Hann window's main lobe, enough for a tremor 4 Hz wide."""
SHORTEST_S = 0.2
"""Shortest stretch of a stroke that is looked at: below it a tremor's peak blurs."""


@dataclass(frozen=True, eq=False)
class NoiseModel:
    """The disturbances of a loop, in newtons."""

    spectrum: xr.DataArray
    """One-sided density of the friction force's fluctuation, N^2/Hz over ``frequency`` (Hz)."""
    shaping: Lti
    """H(s) with |H(j 2 pi f)|^2 the fitted one-sided density: white noise of 1/Hz, one-sided, through it is d."""
    sensor_n_rthz: float
    """One-sided density of the noise in f_m, N/rtHz: electronics and rounding of the converter."""

    def density(self, frequency_hz: ArrayLike) -> Array:
        """Return the fitted one-sided density in N^2/Hz."""
        return np.asarray(np.abs(self.shaping.response(np.asarray(frequency_hz, dtype=float))) ** 2)


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
        raise FrictionloopError(f"motion.kind = {system.motion.kind!r}: friction noise is identified from 'strokes'")
    if not len(seeds):
        raise FrictionloopError("seeds = []: at least one is needed to identify the friction noise")
    law, force = law_at(system, 0.0), asked(system).mean_n
    amplitude = operating_amplitude_um(system, law, None, float(np.clip(force, *reach_n(system, law))))
    stretches = [part for seed in seeds for part in _stretches(plain_stroke(system, amplitude, RUN_S, seed))]
    spectrum = _spectrum(stretches, system.controller.rate_hz)
    shaping, _ = fit_shaping(
        spectrum["frequency"].values, spectrum.values, (system.motion.tremor_hz, system.motion.tremor_width_hz)
    )
    return NoiseModel(spectrum, shaping, _sensor_density(system))


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
        raise FrictionloopError(
            f"the strokes hold {longest / rate_hz:g} s of steady sliding at most: at least {SHORTEST_S:g} s are needed"
        )
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


def _sensor_density(system: System) -> float:
    sensor, nyquist_hz = system.sensor, system.controller.rate_hz / 2
    if isinstance(sensor, LowpassSensor):
        return sensor.noise_rms_n / math.sqrt(nyquist_hz)
    return math.hypot(sensor.noise_density_n_rthz, sensor.step_n / math.sqrt(12.0 * nyquist_hz))
