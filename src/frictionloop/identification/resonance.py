"""The first resonance of the sensor, by least squares on its complex response."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from frictionloop.identification.entry_result import Refused
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.frequency_response import FrequencyResponse
from frictionloop.quantities import must_be

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Resonance:
    """A suspension and a lag, fitted to a frequency response."""

    resonance: Estimate
    """Hz."""
    q: Estimate
    gain: Estimate
    """Reading per force below the resonance, negative if one is turned round; a hammer's own calibration is in it."""
    lag: Estimate
    """Time constant of the pole, in s."""
    band_hz: tuple[float, float]
    misfit: float
    """rms of the residual over that of the response, weighted as in the fit."""

    @property
    def cutoff_hz(self) -> float:
        """Cutoff of the pole, 1/(2 pi lag)."""
        return float(1 / (2 * np.pi * self.lag.value))


def fit_resonance(measured: FrequencyResponse, band_hz: tuple[float, float] | None = None) -> Resonance:
    """Return resonance, Q, gain and lag with their uncertainties.

        H(f) = G / (1 - (f/f0)^2 + j f/(f0 Q)) / (1 + j 2 pi f T)

    Least squares on H over the band, each frequency weighted by the power of the hammer there: that is the likelihood
    for noise of the reading which is white. The covariance is the sandwich (J^T J)^-1 J^T diag(r^2) J (J^T J)^-1 with
    leverages taken off (HC3), which also holds where the noise has the resonance in it, as that of a shaking base has.
    Resonance and Q rest on the few frequencies about the peak, and Student's distribution has as many degrees of
    freedom as those give.

    Parameters
    ----------
    measured : FrequencyResponse
        From `response`.
    band_hz : tuple, optional
        Lower and upper frequency in Hz; None is a fifth to two and a half times that of the largest response, cut at
        what the hammer excites (1 % of its power). At least eight frequencies.

    Raises
    ------
    FrictionloopError
        For a rate too low to show a resonance, a band that is empty or beyond half the rate, or a fit that fails.

    Notes
    -----
    Source: paper, Sec. 3.3 (the resonance); MacKinnon and White, J. Econometrics 29 (1985) 305, for HC3; Satterthwaite,
    Biometrics 2 (1946) 110, for the degrees of freedom.
    """
    low, high = _band(measured, band_hz)
    inside = (measured.frequency_hz >= low) & (measured.frequency_hz <= high)
    if np.count_nonzero(inside) < 8:
        raise must_be("band_hz", (low, high), "around 8 or more frequencies", "Hz")
    frequency, response = measured.frequency_hz[inside], measured.response[inside]
    weight = np.sqrt(measured.input_density[inside] / np.mean(measured.input_density[inside]))
    # A channel that is turned round has a negative gain.
    sign = -1.0 if float(np.sum((weight**2 * response).real[: max(response.size // 8, 4)])) < 0 else 1.0
    response = sign * response
    top = int(np.argmax(np.abs(response)))
    gain = float(np.median(np.abs(response[: max(top // 3, 1)])))

    def residuals(x: Array) -> Array:
        away = weight * (model(frequency, x) - response) / gain
        return np.concatenate([away.real, away.imag])

    # Logarithms keep gain, resonance and Q positive; the lag may come out as anything.
    guess = np.array([np.log(gain), np.log(frequency[top]), np.log(max(abs(response[top]) / gain, 0.6)), 1e-4])
    fit = least_squares(residuals, guess, x_scale=[1e-3, 1e-3, 1e-2, 1e-5], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    found_hz = float(np.exp(fit.x[1]))
    if not (fit.success and low < found_hz < high):
        seen = {**measured.drawn(inside), "fitted": np.abs(model(frequency, fit.x)).tolist()}
        said = must_be("band_hz", (low, high), f"around {found_hz:.4g}", "Hz")
        raise Refused(str(said), "response", {"response": seen})
    errors = sandwich(fit.jac, fit.fun)
    scale = np.array([*np.exp(fit.x[:3]), 1.0])
    values = np.array([sign * np.exp(fit.x[0]), *np.exp(fit.x[1:3]), fit.x[3]])
    units = (measured.unit, "Hz", "", "s")
    gain_, hertz, q, lag_ = (
        Estimate(float(v), float(s * e), u, float(f))
        for v, s, e, u, f in zip(values, scale, errors.standard, units, errors.freedom, strict=True)
    )
    misfit = float(np.linalg.norm(fit.fun) / np.linalg.norm(weight * np.abs(response) / gain))
    return Resonance(hertz, q, gain_, lag_, (low, high), misfit)


def model(frequency_hz: Array, x: Array) -> NDArray[np.complex128]:
    """Return H(f) for x = (log gain, log resonance in Hz, log Q, lag in s)."""
    relative = frequency_hz / np.exp(x[1])
    springs = np.exp(x[0]) / (1 - relative**2 + 1j * relative / np.exp(x[2]))
    return np.asarray(springs / (1 + 2j * np.pi * frequency_hz * x[3]))


class Errors(NamedTuple):
    """Standard errors of fitted parameters and the degrees of freedom behind each."""

    standard: Array
    freedom: Array


def sandwich(jacobian: Array, residuals: Array) -> Errors:
    """Return the HC3 errors of least squares, for residuals that are independent but not equally large.

    A parameter's variance is a sum of c_i^2 r_i^2/(1 - h_i)^2 over residuals r_i with leverages h_i, so a weighted sum
    of squares of normals: it has 3 (sum)^2 / sum of squared terms degrees of freedom (Satterthwaite, with E r^4 =
    3 (E r^2)^2).
    """
    q, r = np.linalg.qr(jacobian)
    leverage = np.minimum(np.sum(q**2, axis=1), 0.99)
    terms = (np.linalg.solve(r, q.T) * (residuals / (1 - leverage))) ** 2
    variance = np.sum(terms, axis=1)
    most = float(residuals.size - jacobian.shape[1])
    squares = np.maximum(np.sum(terms**2, axis=1), 1e-300)
    return Errors(np.sqrt(variance), np.clip(3 * variance**2 / squares, 1.0, most))


def _band(measured: FrequencyResponse, band_hz: tuple[float, float] | None) -> tuple[float, float]:
    half_hz = measured.rate_hz / 2
    if band_hz is not None:
        low, high = (float(end) for end in band_hz)
        if not 0 < low < high <= half_hz:
            raise must_be("band_hz", (low, high), f"rising within 0 to {half_hz:g}", "Hz")
        return low, high
    excited = measured.input_density >= 0.01 * np.max(measured.input_density)
    upto = measured.frequency_hz[excited]
    peak_hz = float(upto[np.argmax(np.abs(measured.response[excited]))])
    if peak_hz > 0.8 * half_hz:
        raise must_be("recording: rate", measured.rate_hz, f"four times the resonance, above {peak_hz:g}", "Hz")
    return 0.2 * peak_hz, min(2.5 * peak_hz, float(upto[-1]))
