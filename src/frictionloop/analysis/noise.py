"""Sensor noise in the friction force and in the command: equation (3) as a variance, an integral, and as printed."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.integrate import tanhsinh

from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.responses import Reading
from frictionloop.analysis.state_space import Array, Complex
from frictionloop.parameters import LowpassSensor, System
from frictionloop.quantities import FrictionloopError
from frictionloop.sensing.suspended import noise_coefficients


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


def integrated_noise_rms_n(system: System | LinearLoop, output: str = "f_a", reading: Reading = "sampled") -> float:
    """Return the same rms as an integral over the noise's spectrum, N: equation (3) summed over frequency.

    sigma_f^2 = integral from 0 to rate/2 of 2 sigma_n^2 Ts |f_a_from_n(f)|^2 df, where 2 sigma_n^2 Ts is the
    one-sided density of the noise and f_a_from_n is -G/(1+G) in every continuous reading without springs.

    Parameters
    ----------
    system
        The loop, or its `LinearLoop` at an operating point.
    output
        "f_a" or "u".
    reading
        As in `LinearLoop.frequency_response`. "sampled" equals `output_noise_rms_n`; it is infinite when the loop
        is unstable. The continuous readings do not know about that and return the integral as it stands.

    Raises
    ------
    FrictionloopError
        Another output or reading.
    """
    loop = _linear(system)
    if output not in ("f_a", "u"):
        raise FrictionloopError(f"output = {output!r}: accepted are 'f_a', 'u'")
    if reading == "sampled" and not loop.is_stable():
        return math.inf

    def power(frequency: Array) -> Array:
        return _spectrum(loop, loop.responses(frequency.ravel(), reading), output).reshape(frequency.shape)

    edges = panel_edges(loop, loop.poles())
    panels = tanhsinh(power, edges[:-1], edges[1:], rtol=1e-10, atol=0.0)
    return math.sqrt(float(np.sum(panels.integral)))


def noise_spectrum(system: System | LinearLoop, frequency_hz: ArrayLike, reading: Reading = "sampled") -> xr.Dataset:
    """Return the one-sided spectra of f_a and u that the sensor noise causes, N^2/Hz over ``frequency`` in Hz.

    2 sigma_n^2 Ts |f_a_from_n|^2, and as much for a converter: the integrand of equation (3). Arguments as in
    `LinearLoop.frequency_response`.
    """
    loop = _linear(system)
    response = loop.frequency_response(frequency_hz, reading)
    values = {str(name): variable.values for name, variable in response.items()}
    spectra = {f: ("frequency", _spectrum(loop, values, f), {"units": "N^2/Hz"}) for f in ("f_a", "u")}
    return xr.Dataset(spectra, response.coords, response.attrs)


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
    return math.sqrt(sum(sigma**2 * closed.variance(source)[output] for source, sigma in _sources(loop).items()))


def _sources(loop: LinearLoop) -> dict[str, float]:
    """Return the standard deviations, N, of what is drawn anew each period, by the input it enters at.

    The noise is held over its period before the sensor's pole; that of a suspended sensor is given behind the pole,
    where such draws leave gain/(1 - decay) times less. Rounding is an error of the reading.
    """
    sensor = loop.system.sensor
    decay, gain = noise_coefficients(sensor, loop.plant.period_s)
    if isinstance(sensor, LowpassSensor):
        return {"n": sensor.noise_rms_n}
    return {"n": gain / (1.0 - decay), "q": sensor.step_n / math.sqrt(12.0)}


def _spectrum(loop: LinearLoop, responses: Mapping[str, Complex], output: str) -> Array:
    """Return the one-sided density of an output, N^2/Hz."""
    powers = [sigma**2 * np.abs(responses[f"{output}_from_{source}"]) ** 2 for source, sigma in _sources(loop).items()]
    return np.asarray(2.0 * loop.plant.period_s * np.sum(powers, axis=0))


def panel_edges(loop: LinearLoop, poles: Complex) -> Array:
    """Return the frequencies that cut 0 to the Nyquist frequency into panels on which what has these poles is smooth.

    A pole makes a peak at its frequency, as wide as its damping: panels grow from there by factors of 8.
    """
    logs = np.log(poles[np.abs(poles) > 1e-6]) / (2 * np.pi * loop.plant.period_s)
    widths = np.abs(logs.real)[:, None] * 8.0 ** np.arange(-1, 20)
    centres = np.abs(logs.imag)[:, None]
    edges = np.concatenate([centres, centres - widths, centres + widths], axis=1).ravel()
    tiny = 1e-12 * loop.nyquist_hz  # the spectrum is finite at 0, only its formula is not
    return np.unique([tiny, *edges[(edges > 2 * tiny) & (edges < loop.nyquist_hz)], loop.nyquist_hz])
