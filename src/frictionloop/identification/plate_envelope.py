"""Corner of the plate's envelope from how its recorded amplitude rises or falls after a jump of the drive."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import least_squares

from frictionloop.identification.channels import channel, rate_of
from frictionloop.identification.drive_jumps import CONSTANTS, WORST_MISFIT, jumps_of
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.plate_sweep import VIBRATIONS
from frictionloop.identification.resonance import sandwich
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]


class PlateEnvelope(NamedTuple):
    """How fast the amplitude follows, where only the amplitude was recorded."""

    corner: Estimate
    """Hz."""
    method_hz: float
    """Standard error in Hz from where the fit begins."""
    jumps: int
    misfit: float
    time_s: Array
    """The first jump, drawn."""
    y: Array
    fitted: Array


def plate_envelope(recording: xr.Dataset) -> PlateEnvelope:
    """Return the corner 1/(2 pi T) from the recorded amplitude, A(t) = A1 + (A0 - A1) e^(-t/T) after each jump.

    Parameters
    ----------
    recording : xarray.Dataset
        ``envelope`` in um, m/s or V over ``time`` in s: the amplitude, as a lock-in or a rectifier gives it.

    Raises
    ------
    FrictionloopError
        For a column that is missing, no jump, or a rise or fall that one time constant does not explain.
    """
    envelope, rate_hz = channel(recording, "envelope", VIBRATIONS), rate_of(recording)
    size = max(min(envelope.size // 2000, round(2e-4 * rate_hz)), 1)
    fits, late, drawn = [], [], None
    for start, stop, _ in jumps_of(envelope, size):
        piece = envelope[start + 1 : stop]
        constant = _exponential(piece, rate_hz)[0] * rate_hz
        piece = piece[: max(round(CONSTANTS * constant), 12)]
        fits.append(_exponential(piece, rate_hz))
        late.append(_exponential(piece[round(constant / 2) :], rate_hz))
        drawn = drawn or (piece, fits[-1])
    times = np.array([fit[0] for fit in fits])
    misfit = float(np.median([fit[1] for fit in fits]))
    if misfit > WORST_MISFIT or drawn is None:
        raise FrictionloopError(
            f"recording: one time constant ({1e3 * times.mean():.3g} ms) leaves {misfit:.0%} of a rise or fall "
            f"unexplained: must be at most {WORST_MISFIT:.0%}"
        )
    mean = float(times.mean())
    error = float(times.std(ddof=1)) / math.sqrt(times.size) if times.size > 1 else fits[0][2]
    freedom = times.size - 1.0 if times.size > 1 else max(drawn[0].size - 3.0, 1.0)
    corner = 1 / (2 * math.pi * mean)
    moved = abs(float(np.mean([fit[0] for fit in late])) - mean) / math.sqrt(3)
    return PlateEnvelope(
        Estimate(corner, corner * error / mean, "Hz", freedom), corner * moved / mean, times.size, misfit,
        np.arange(drawn[0].size) / rate_hz, drawn[0], drawn[1][3],
    )  # fmt: skip


def _exponential(piece: Array, rate_hz: float) -> tuple[float, float, float, Array]:
    """Return the time constant in s, the misfit, the error of the time, and the fitted curve."""
    time = np.arange(piece.size) / rate_hz

    def fitted(x: Array) -> Array:
        columns = np.stack([np.ones_like(time), np.exp(-time / math.exp(x[0]))], axis=1)
        return np.asarray(columns @ np.linalg.lstsq(columns, piece, rcond=None)[0])

    ends = float(piece[0]), float(np.median(piece[-max(piece.size // 10, 1) :]))
    inner = np.flatnonzero(np.abs(piece - ends[1]) < abs(ends[0] - ends[1]) / math.e)
    guess = max(float(inner[0]) if inner.size else 1.0, 1.0) / rate_hz
    fit = least_squares(lambda x: fitted(x) - piece, [math.log(guess)], x_scale=0.1)
    constant = math.exp(fit.x[0])
    error = constant * float(sandwich(fit.jac, fit.fun).standard[0])
    return constant, float(np.linalg.norm(fit.fun) / np.linalg.norm(piece - ends[1])), error, fitted(fit.x)
