"""The low-pass that noise of the sensor has passed: its corner and what went in, by maximum likelihood."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.noise_density import OVERLAP_EXCESS, NoiseSpectrum, frequencies_inside
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FirstOrderNoise:
    """White noise behind a first-order low-pass, and the white noise of a converter."""

    density: Estimate
    """Before the low-pass, N/rtHz."""
    corner: Estimate
    """Cutoff of the low-pass in Hz."""
    white: Estimate
    """After it, N/rtHz."""


def fit_corner(spectrum: NoiseSpectrum, low_hz: float, high_hz: float) -> FirstOrderNoise:
    """Return density and corner of noise behind a first-order low-pass, as sampled.

        S(f) = s^2 (pi fc / rate) (1 - q^2)/(1 + q^2 - 2 q cos(2 pi f/rate)) + w^2,   q = e^(-2 pi fc/rate)

    is s^2/(1 + (f/fc)^2) with all that folds down from above half the rate, which at 5 kHz is not little. Whittle's
    likelihood, sum of log S + estimate/S, is made smallest; standard errors from its Fisher information.

    Parameters
    ----------
    spectrum : NoiseSpectrum
        From `noise_spectrum`.
    low_hz, high_hz : float
        Ends of the band in Hz. A resonance must be outside; the corner should be inside.

    Raises
    ------
    FrictionloopError
        For a band that is empty or not within the spectrum, or a spectrum without power in it.
    """
    inside = frequencies_inside(spectrum, low_hz, high_hz)
    frequency, power = spectrum.frequency_hz[inside], spectrum.power_density[inside]
    if not np.all(power > 0):
        raise FrictionloopError(
            "recording: there is no noise in the band; is the converter's step wider than the noise?"
        )
    rate = spectrum.rate_hz

    def shape(x: Array) -> Array:
        q = math.exp(-2 * math.pi * math.exp(x[1]) / rate)
        folded = (1 - q * q) / (1 + q * q - 2 * q * np.cos(2 * np.pi * frequency / rate))
        return np.asarray(math.exp(2 * x[0]) * math.pi * math.exp(x[1]) / rate * folded + math.exp(2 * x[2]))

    def slopes(x: Array) -> Array:
        """Return d log S/dx, by central differences of an exact formula."""
        small = 1e-5 * np.eye(3)
        return np.column_stack([(np.log(shape(x + d)) - np.log(shape(x - d))) / 2e-5 for d in small])

    def unlikeliness(x: Array) -> float:
        s = shape(x)
        return float(np.mean(np.log(s) + power / s))

    def gradient(x: Array) -> Array:
        return np.asarray(slopes(x).T @ (1 - power / shape(x)) / power.size)

    def curvature(x: Array) -> Array:
        """Return the expected second derivative, which is never negative: Fisher's information."""
        slope = slopes(x)
        return np.asarray(slope.T @ slope / power.size)

    ends = max(power.size // 20, 4)
    low_level, high_level = (math.log(float(np.mean(part))) / 2 for part in (power[:ends], power[-ends:]))
    corners = np.geomspace(2 * frequency[0], high_hz, 12)
    start = min((np.array([low_level, math.log(c), high_level - 1.0]) for c in corners), key=unlikeliness)
    options = {"gtol": 1e-9, "maxiter": 200}
    x = minimize(unlikeliness, start, jac=gradient, hess=curvature, method="trust-exact", options=options).x
    slope = slopes(x)
    # A band's scatter is 19/18/T per Hz: so much information does each frequency carry.
    step_hz = float(frequency[1] - frequency[0])
    information = slope.T @ slope * spectrum.duration_s * step_hz / OVERLAP_EXCESS
    error = np.sqrt(np.diag(np.linalg.pinv(information)))
    values = np.exp(x)
    unit = f"{spectrum.unit}/rtHz"
    density, corner, white = (
        Estimate(float(v), float(v * e), u) for v, e, u in zip(values, error, (unit, "Hz", unit), strict=True)
    )
    return FirstOrderNoise(density, corner, white)
