"""Linear loops looked at in other ways than the package does: run in time, and noise summed over frequency."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import tanhsinh
from scipy.signal import dlsim

from frictionloop.analysis.disturbance_spectrum import noise_sources
from frictionloop.analysis.limits import panel_edges
from frictionloop.analysis.linear import LinearLoop


def run_linear(space, inputs: np.ndarray) -> np.ndarray:
    """Return the outputs of a state space, shape (periods, outputs), for inputs (periods, inputs) from rest."""
    return np.asarray(dlsim((space.A, space.B, space.C, space.D, space.period_s), inputs)[1])


def noise_spectrum(loop: LinearLoop, frequency_hz: np.ndarray, output: str, reading: str = "sampled") -> np.ndarray:
    """Return the one-sided density of an output that sensor noise causes, N^2/Hz: 2 sigma_n^2 Ts |f_a_from_n|^2."""
    responses = loop.responses(frequency_hz, reading)
    powers = [
        sigma**2 * np.abs(responses[f"{output}_from_{source}"]) ** 2 for source, sigma in noise_sources(loop).items()
    ]
    return 2.0 * loop.plant.period_s * np.sum(powers, axis=0)


def integrated_noise_rms_n(loop: LinearLoop, output: str = "f_a", reading: str = "sampled") -> float:
    """Return equation (3) as an integral over the spectrum from 0 to half the rate, N."""

    def power(frequency: np.ndarray) -> np.ndarray:
        return noise_spectrum(loop, frequency.ravel(), output, reading).reshape(frequency.shape)

    edges = panel_edges(loop, loop.poles())
    return math.sqrt(float(np.sum(tanhsinh(power, edges[:-1], edges[1:], rtol=1e-10, atol=0.0).integral)))
