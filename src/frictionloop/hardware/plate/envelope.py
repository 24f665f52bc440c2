"""How fast the amplitude of a driven resonance follows its drive: Q, bandwidth, and the beat of a detuned drive.

The plate's displacement is the real part of A(t) e^(j 2 pi f t), f the carrier. Its complex envelope A obeys (Q >> 1)

    dA/dt = -(1/T - j 2 pi df) A + c/T,    T = 2Q/omega0 = Q/(pi f0),  df = f0 - f,

c being the amplitude that the same drive reaches at resonance. The error of this is of the order 1/(2Q).
"""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import lfilter

from frictionloop.quantities import must_be
from frictionloop.quantities.checks import ABOVE_0, number


def time_constant_s(resonance_hz: float, quality_factor: float) -> float:
    """Return T = Q/(pi f0), the time in which a free vibration falls to 1/e."""
    return quality_factor / (math.pi * resonance_hz)


def bandwidth_hz(resonance_hz: float, quality_factor: float) -> float:
    """Return the cutoff f0/(2Q) of the first-order envelope, what ``plate.cutoff_hz`` of a System is."""
    return 1.0 / (2.0 * math.pi * time_constant_s(resonance_hz, quality_factor))


def quality_for_bandwidth(resonance_hz: float, bandwidth: float) -> float:
    """Return the Q = f0/(2B) that gives an envelope bandwidth B in Hz.

    Raises
    ------
    FrictionloopError
        For a bandwidth that is not between 0 and f0, where Q would be 1/2.
    """
    number("bandwidth_hz", bandwidth, "Hz", ABOVE_0)
    if bandwidth >= resonance_hz:
        raise must_be("bandwidth_hz", bandwidth, f"below the resonance, {resonance_hz:g}", "Hz")
    return resonance_hz / (2.0 * bandwidth)


def envelope_pole(resonance_hz: float, quality_factor: float, detuning_hz: float = 0.0) -> complex:
    """Return the pole -1/T + j 2 pi df of the complex envelope in rad/s; the amplitude has it and its conjugate.

    The detuning is the carrier less the resonance, -df.
    """
    return complex(-1.0 / time_constant_s(resonance_hz, quality_factor), -2.0 * math.pi * detuning_hz)


def detuned_gain(resonance_hz: float, quality_factor: float, detuning_hz: float) -> float:
    """Return the steady amplitude of a detuned drive over that at resonance, 1/sqrt(1 + (2 pi df T)^2)."""
    pole = envelope_pole(resonance_hz, quality_factor, detuning_hz)
    return -pole.real / abs(pole)


def envelope(command: np.ndarray, step_s: float, pole: complex, start: complex = 0.0) -> np.ndarray:
    """Return the complex envelope at the start of every step and after the last one, exact for held commands.

    Commands are complex if the phase of the carrier moves with them.
    """
    held = np.append(np.asarray(command, dtype=complex), 0.0)
    target = held * (pole.real / pole)  # what A settles on: c/(1 - j 2 pi df T)
    decay = np.exp(pole * step_s)
    # a[k+1] = decay a[k] + (1 - decay) target[k]
    found, _ = lfilter([0.0, 1.0 - decay], [1.0, -decay], target, zi=np.array([start + 0j]))
    return np.asarray(found)
