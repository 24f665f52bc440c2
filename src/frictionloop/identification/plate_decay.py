"""Resonance and Q of the plate from how its vibration rises or falls after a jump of the drive."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import least_squares

from frictionloop.identification.channels import channel, rate_of
from frictionloop.identification.drive_jumps import CONSTANTS, WORST_MISFIT, jumps_of
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.plate_sweep import VIBRATIONS, PlateResonance
from frictionloop.identification.resonance import sandwich
from frictionloop.identification.ring_down import damped
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
Ring = tuple[float, float, float, float, float, Array]


def plate_decay(recording: xr.Dataset) -> PlateResonance:
    """Return resonance and Q from the vibration itself, sampled above twice the resonance, after the drive jumps.

        y(t) = c + e^(-w t/(2 Q)) (a cos w_d t + b sin w_d t) + (what the drive holds, at its own frequency)

    by least squares for each rise or fall; the estimate is the mean, their scatter its standard error, and that of a
    single one the fit's own. The method's error is how far the values move when the fit begins a time constant later.

    Parameters
    ----------
    recording : xarray.Dataset
        ``vibration`` in um, m/s or V over ``time`` in s; the jumps are found in it.

    Raises
    ------
    FrictionloopError
        For a column that is missing, no jump, a rate too low, or a decay that one resonance does not explain.
    """
    y, rate_hz = channel(recording, "vibration", VIBRATIONS), rate_of(recording)
    y = y - y.mean()
    spectrum = np.abs(np.fft.rfft(y * np.hanning(y.size)))
    carrier_hz = float(np.fft.rfftfreq(y.size, 1 / rate_hz)[1 + int(np.argmax(spectrum[1:]))])
    if carrier_hz > 0.45 * rate_hz:
        raise FrictionloopError(
            f"recording: it vibrates at {carrier_hz:.5g} Hz, near half its rate of {rate_hz:g} Hz: must be sampled "
            "faster, or recorded as 'envelope'"
        )
    size = max(round(4 * rate_hz / carrier_hz), 4)
    envelope = np.sqrt(2 * np.convolve(y**2, np.ones(size) / size, mode="same"))
    fits, late, drawn, falls = [], [], None, True
    for start, stop, falls in jumps_of(envelope, size):
        piece = y[start + size : stop]
        first = _ring(piece, rate_hz, carrier_hz, falls)
        constant = round(rate_hz * first[1] / (math.pi * first[0]))
        piece = piece[: round(CONSTANTS * constant)]
        fits.append(_ring(piece, rate_hz, carrier_hz, falls))
        late.append(_ring(piece[constant:], rate_hz, carrier_hz, falls))
        drawn = drawn or (piece, fits[-1])
    values, errors, freedom, moved = _over(fits, late)
    misfit = float(np.median([fit[2] for fit in fits]))
    if misfit > WORST_MISFIT or drawn is None:
        raise FrictionloopError(
            f"recording: one resonance at {values[0]:.5g} Hz leaves {misfit:.0%} of a decay unexplained: must be at "
            f"most {WORST_MISFIT:.0%}"
        )
    return PlateResonance(
        Estimate(values[0], errors[0], "Hz", freedom),
        Estimate(values[1], errors[1], "", freedom),
        moved[0],
        moved[1],
        misfit,
        f"{len(fits)} {'falls' if falls else 'rises'} of the vibration",
        (f"one resonance leaves {misfit:.1%} of a {'fall' if falls else 'rise'}",),
        np.arange(drawn[0].size) / rate_hz,
        drawn[0],
        drawn[1][5],
    )


def _ring(piece: Array, rate_hz: float, carrier_hz: float, falls: bool) -> Ring:
    """Return resonance in Hz, Q, misfit, the errors of both, and the fitted curve."""
    time = np.arange(piece.size) / rate_hz
    width = carrier_hz / 100

    def shape(x: Array) -> Array:
        columns = damped(time, [(carrier_hz + width * x[0], math.exp(x[1]))])
        if falls:
            return columns
        angle = 2 * math.pi * (carrier_hz + width * x[2]) * time
        return np.column_stack([columns, np.cos(angle), np.sin(angle)])

    def fitted(x: Array) -> Array:
        columns = shape(x)
        weight = np.linalg.lstsq(columns.T @ columns, columns.T @ piece, rcond=1e-13)[0]
        return np.asarray(columns @ weight)

    near = 0.0
    if falls:
        spectrum = np.abs(np.fft.rfft(piece, 8 * piece.size))
        near = (float(np.fft.rfftfreq(8 * piece.size, 1 / rate_hz)[int(np.argmax(spectrum))]) - carrier_hz) / width
    starts = [[near, math.log(q), *([] if falls else [0.0])] for q in (50.0, 300.0)]
    tried = [least_squares(lambda x: fitted(x) - piece, start, x_scale=0.1) for start in starts]
    best = min(tried, key=lambda fit: float(fit.cost))
    errors = sandwich(best.jac, best.fun).standard
    q = math.exp(best.x[1])
    misfit = float(np.linalg.norm(best.fun) / max(float(np.linalg.norm(piece)), 1e-300))
    hertz = float(carrier_hz + width * best.x[0])
    return hertz, q, misfit, float(width * errors[0]), float(q * errors[1]), fitted(best.x)


def _over(fits: list[Ring], late: list[Ring]) -> tuple[list[float], list[float], float, list[float]]:
    """Return mean, standard error, degrees of freedom, and how far later fits move the mean, of resonance and Q."""
    both, other = (np.array([fit[:2] for fit in each]) for each in (fits, late))
    if len(fits) > 1:
        errors, freedom = both.std(axis=0, ddof=1) / math.sqrt(len(fits)), len(fits) - 1.0
    else:
        errors, freedom = np.array(fits[0][3:5]), math.inf
    moved = np.abs(other.mean(axis=0) - both.mean(axis=0)) / math.sqrt(3)
    return both.mean(axis=0).tolist(), errors.tolist(), freedom, moved.tolist()
