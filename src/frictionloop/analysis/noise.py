"""Sensor noise in the friction force and in the command: equation (3) as a variance, and as printed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.responses import Reading
from frictionloop.analysis.state_space import Array
from frictionloop.parameters import LowpassSensor, System
from frictionloop.sensing.force_sensor import noise_coefficients


def output_noise_rms_n(system: System | LinearLoop) -> float:
    """Return sigma_f, the rms of f_a that the sensor noise causes, N: equation (3) for the loop as it runs.

    Exact stationary variance at the sampling instants of the sampled loop (discrete Lyapunov equation). A sensor of
    Section 2 has white noise of ``sensor.noise_rms_n`` drawn once per control period. A suspended one has
    ``noise_density_n_rthz`` before its pole and, after it, the converter's rounding: white noise of step/sqrt(12)
    (Widrow), true while the noise before it moves the reading by about a step or more. Infinite when the loop is
    unstable. Small signals: the clamp and the curvature of the friction law are not in it.

    Parameters
    ----------
    system
        The loop (at the operating point of `linearise`), or its `LinearLoop` at another one.

    Raises
    ------
    FrictionloopError
        For what is neither, or an operating point that cannot be reached.
    """
    return _rms_n(system, "f_a")


def command_noise_rms_n(system: System | LinearLoop) -> float:
    """Return the rms of the force command u that the sensor noise causes, N; otherwise as `output_noise_rms_n`.

    Parameters
    ----------
    system
        The loop (at the operating point of `linearise`), or its `LinearLoop` at another one.

    Raises
    ------
    FrictionloopError
        For what is neither, or an operating point that cannot be reached.
    """
    return _rms_n(system, "u")


def equation_3_rms_n(system: System | LinearLoop, frequency_hz: ArrayLike, reading: Reading = "printed") -> Array:
    """Return |G/(1+G)| sigma_n in N at single frequencies in Hz: equation (3) as printed, true for a tone only."""
    loop = _linear(system)
    gain = np.abs(loop.responses(frequency_hz, reading)["T"])
    return np.asarray(gain * loop.system.sensor.noise_rms_n)


def _linear(system: System | LinearLoop) -> LinearLoop:
    return system if isinstance(system, LinearLoop) else linearise(system)


def _rms_n(system: System | LinearLoop, output: str) -> float:
    loop = _linear(system)
    closed = loop.state_space(("n", "q"))
    return math.sqrt(sum(sigma**2 * closed.variance(source)[output] for source, sigma in noise_sources(loop).items()))


def noise_sources(loop: LinearLoop) -> dict[str, float]:
    """Return the standard deviations, N, of what is drawn anew each period, by the input it enters at.

    The noise is held over its period before the sensor's pole; that of a suspended sensor is given behind the pole,
    where such draws leave gain/(1 - decay) times less. Rounding is an error of the reading.
    """
    sensor = loop.system.sensor
    decay, gain = noise_coefficients(sensor, loop.plant.period_s)
    if isinstance(sensor, LowpassSensor):
        return {"n": sensor.noise_rms_n}
    return {"n": gain / (1.0 - decay), "q": sensor.step_n / math.sqrt(12.0)}
