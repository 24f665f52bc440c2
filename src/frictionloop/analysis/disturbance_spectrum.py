"""What moves the force of a sliding finger as a spectrum, and what sensor noise makes of it: equation (3)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.analysis.linear import LinearLoop, Reading, linearise
from frictionloop.analysis.operating_point import force_band
from frictionloop.parameters import FingerFriction, LowpassSensor, Sine, Strokes, System
from frictionloop.physics.roughness import WAVES
from frictionloop.quantities import Array, FrictionloopError
from frictionloop.sensing.force_sensor import noise_coefficients

Spectrum = Callable[[Array], Array]
"""Frequencies in Hz to a power density in N^2/Hz, one-sided."""
LINE = 0.2
"""Width of a sine in the spectrum, relative to its frequency: narrow against the loop, wide against the grids."""


def touch_spectrum(system: System, setpoint_share: float = 1.0) -> Spectrum:
    """Return the power density of what moves the force of a stroking finger, around the mean force F asked for.

    - roughness: (F r)^2 / (f ln 1024) from v/L to 1024 v/L, 1/f as `roughness_table`;
    - tremor and drift of the load, each times n F/N0 (exponent n): the resonance of physics/tremor, and a first-order
      noise with the drift's period;
    - a sine as set-point: its power as a line 20 % wide, times ``setpoint_share`` squared.

    Parameters
    ----------
    system
        A finger that strokes: friction of kind "finger", motion of kind "strokes".
    setpoint_share
        Share of the set-point that is left to the feedback: 1 without feed-forward; with it the relative error of the
        model's gain (0.3 for fingers that were not calibrated, assumed: spread of tau).

    Raises
    ------
    FrictionloopError
        For friction or motion of another kind.
    """
    friction, motion, setpoint = system.friction, system.motion, system.setpoint
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        raise FrictionloopError('friction.kind, motion.kind: needs "finger", "strokes"')
    force = force_band(system).mean_n
    per_load = friction.load_exponent * force / motion.load_n
    lowest = motion.speed_mm_s / friction.roughness_longest_mm

    def density(frequency_hz: ArrayLike) -> Array:
        f = np.asarray(frequency_hz, dtype=float)
        rough = (force * friction.roughness_rms) ** 2 / (f * math.log(WAVES))
        total = np.where((f >= lowest) & (f <= WAVES * lowest), rough, 0.0)
        total += (per_load * motion.tremor_n) ** 2 * _resonance(f, motion.tremor_hz, motion.tremor_width_hz)
        total += (per_load * motion.load_n * motion.load_drift) ** 2 * _first_order(f, 1.0 / motion.load_drift_s)
        if isinstance(setpoint, Sine):
            power = 0.5 * (setpoint_share * setpoint.amplitude_n) ** 2
            total += power * _line(f, setpoint.frequency_hz)
        return np.asarray(total)

    return density


def _resonance(f: Array, peak_hz: float, width_hz: float) -> Array:
    """Unit power behind 1 / (s^2 + 2 pi b s + w^2), whose variance is 1 / (4 pi b w^2) per two-sided density."""
    omega2 = (2 * math.pi * peak_hz) ** 2 + 2 * (math.pi * width_hz) ** 2
    s = 2j * math.pi * f
    return np.asarray(8 * math.pi * width_hz * omega2 / np.abs(s * s + 2 * math.pi * width_hz * s + omega2) ** 2)


def _first_order(f: Array, corner_hz: float) -> Array:
    """Unit power behind 1 / (1 + j f/fc)."""
    return np.asarray(2.0 / (math.pi * corner_hz) / (1.0 + (f / corner_hz) ** 2))


def _line(f: Array, centre_hz: float) -> Array:
    """Unit power around a frequency (Gaussian)."""
    width = 0.5 * LINE * centre_hz
    return np.asarray(np.exp(-0.5 * ((f - centre_hz) / width) ** 2) / (width * math.sqrt(2 * math.pi)))


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
