"""How friction may fall with the amplitude, and one such law fitted to pieces of a finger, with moisture and load."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import lfilter, savgol_filter

from frictionloop.identification.recording_columns import READING, channel, rate_of, runs_of
from frictionloop.quantities import Array, must_be

AMPLITUDES = ("amplitude", "a")
"""Names of the channel with the amplitude in um: a lab's, and a run's or a device's."""
AMPLITUDE_UNITS = ("um", "V", "")
"""Volts and duties too, so that electroadhesion is recognised before a scale is asked for."""
STEADY = 0.7
"""A finger slides where its speed is above this share of the median of its movement (assumed)."""
TOUCHING = 0.3
"""A finger touches above this share of the largest usual load, the 90th percentile (assumed)."""
TURN_S = 0.1
"""Time left out on both sides of a turn, while the skin is stretched the other way (assumed)."""
SETTLE_S = 0.06
"""Time left out after a jump of the amplitude: friction rises by at most stiffness times speed, 20 N/s (assumed)."""
JUMP = 0.1
"""A jump is a change of the amplitude squared by more than this share of the largest within 5 ms (assumed)."""
SPEED_S = 0.05
"""Window of the speed that follows from a position: a turn takes longer (assumed)."""
LEAST_PIECES = 40
"""Pieces that a fit of up to seven numbers needs at least (assumed)."""
LEAST_SHARE = 0.02
"""Least share of the friction that the threshold law leaves: its straight line would go on below 0 (assumed)."""
REFERENCE_LOAD_N = 0.5
"""Load that f0 is told for, that of `bench` (``friction.reference_load_n``, assumed there)."""
PRIORS = {
    "load": (0.85, 0.2),
    "occlusion": (1.0, 3.0),
    "loss": (0.15, 0.3),
    "log_time": (math.log(20.0), math.log(2.0)),
}
"""Middle and width of what is known beforehand, which decides where a recording says nothing: load exponent (2/3 to 1
on smooth glass: Dzidek 2014), growth of the friction in contact (up to 10 times: Adams 2013), share of tau that
moisture takes (direction: Gueorguiev 2017; width assumed), logarithm of the time in s in which moisture builds up
(20 s: Pasumarty 2011, paper ref. [9]; width assumed)."""
FIXED = 5


class Pieces(NamedTuple):
    """Pieces in order of time; arrays over pieces, ``amplitude_um`` over pieces and samples."""

    log_friction: Array
    """Logarithm of the mean friction in N."""
    log_load: Array
    """Logarithm of the mean load in N."""
    contact_s: Array
    """Time since the finger landed, or since the start of a recording in which it never lifts."""
    amplitude_um: Array
    follows: NDArray[np.bool_]
    """Whether the piece begins where the one before it ends."""


def sliding_pieces(recording: xr.Dataset, piece_s: float, plate_hz: float | None = None) -> Pieces:
    """Return the pieces in which a finger slides steadily and the amplitude has not just jumped.

    Friction is positive against the motion: of every stroke its mean is.

    Parameters
    ----------
    recording : xarray.Dataset
        Columns ``f_m`` and ``load`` in N, ``amplitude`` (or ``a``), ``position`` in m or ``speed`` in m/s, over
        ``time`` in s.
    piece_s : float
        Length of a piece in s.
    plate_hz : float, optional
        Cutoff of the plate's envelope in Hz, where the amplitude is a command; None: it was measured.

    Raises
    ------
    FrictionloopError
        For a column that is missing or has another unit, or fewer than 40 pieces.
    """
    force, load, rate_hz = channel(recording, READING, ("N",)), channel(recording, "load", ("N",)), rate_of(recording)
    name = next((each for each in AMPLITUDES if each in recording), AMPLITUDES[0])
    amplitude = np.abs(channel(recording, name, AMPLITUDE_UNITS))
    if plate_hz is not None:
        decay = float(np.exp(-2 * np.pi * plate_hz / rate_hz))
        amplitude = lfilter([1 - decay], [1, -decay], amplitude, zi=[decay * amplitude[0]])[0]
    speed = _speed(recording, rate_hz)
    touches = load > TOUCHING * np.percentile(load, 90)
    slides = _slides(speed, touches, rate_hz) & ~_after_jumps(amplitude, rate_hz)
    landed = np.maximum.accumulate(np.where(np.diff(touches, prepend=touches[0]), np.arange(touches.size), 0))
    size = max(round(piece_s * rate_hz), 4)
    rows: list[tuple[float, float, float, bool]] = []
    amplitudes: list[Array] = []
    for first, stop in runs_of(slides):
        sign = np.sign(force[first:stop].mean())
        for k, start in enumerate(range(first, stop - size + 1, size)):
            piece = slice(start, start + size)
            friction, pressed = float(sign * force[piece].mean()), float(load[piece].mean())
            if friction > 0 and pressed > 0:
                middle = start + size // 2
                since = (middle - landed[middle]) / rate_hz
                rows.append((np.log(friction), np.log(pressed), since, k > 0))
                amplitudes.append(amplitude[piece])
    if len(rows) < LEAST_PIECES:
        raise must_be(f"recording: sliding pieces of {piece_s:g} s", len(rows), f"at least {LEAST_PIECES}")
    friction_, load_, contact, follows = (np.array(each) for each in zip(*rows, strict=True))
    return Pieces(friction_, load_, contact, np.array(amplitudes), follows.astype(bool))


def _speed(recording: xr.Dataset, rate_hz: float) -> Array:
    if "speed" in recording and "position" not in recording:
        return channel(recording, "speed", ("m/s",))
    position = channel(recording, "position", ("m",))
    window = max(int(SPEED_S * rate_hz) // 2 * 2 + 1, 5)
    return np.asarray(savgol_filter(position, min(window, position.size // 2 * 2 - 1), 2, deriv=1, delta=1 / rate_hz))


def _slides(speed: Array, touches: NDArray[np.bool_], rate_hz: float) -> NDArray[np.bool_]:
    """Return where a finger touches and slides at its usual speed, away from its turns."""
    moving = touches & (np.abs(speed) > 0.1 * np.percentile(np.abs(speed), 95))
    usual = float(np.median(np.abs(speed[moving]))) if moving.any() else np.inf
    steady = touches & (np.abs(speed) > STEADY * usual)
    margin = max(round(TURN_S * rate_hz), 1)
    return np.asarray(_grown(~steady, margin, margin) == 0)


def _after_jumps(amplitude: Array, rate_hz: float) -> NDArray[np.bool_]:
    lag = max(round(5e-3 * rate_hz), 1)
    square = amplitude**2
    moved = np.abs(square - np.concatenate([np.full(lag, square[0]), square[:-lag]]))
    return _grown(moved > JUMP * square.max(), 0, round(SETTLE_S * rate_hz)) > 0


def _grown(found: NDArray[np.bool_], before: int, after: int) -> NDArray[np.int64]:
    """Return how many found rows lie from ``after`` rows before each row to ``before`` rows after it."""
    total = np.concatenate([[0], np.cumsum(found)])
    rows = np.arange(found.size)
    return np.asarray(total[np.minimum(rows + before + 1, found.size)] - total[np.maximum(rows - after, 0)])


class AmplitudeLaw(NamedTuple):
    """One law; ``exponent(a, x, largest)`` is -log of the share of friction that is left."""

    name: str
    words: str
    exponent: Callable[[Array, Array, float], Array]
    start: tuple[float, ...] = (1.0,)
    low: tuple[float, ...] = (-5.0,)
    high: tuple[float, ...] = (50.0,)


def _threshold(amplitude_um: Array, x: Array, largest_um: float) -> Array:
    beyond = np.maximum(amplitude_um / largest_um - x[1], 0.0)
    return np.asarray(-np.log(np.maximum(1.0 - x[0] * beyond, LEAST_SHARE)))


LAWS = (
    AmplitudeLaw("gaussian", "exp(-tau a^2)", lambda a, x, most: x[0] * (a / most) ** 2),
    AmplitudeLaw("exponential", "exp(-a/a1): rough contact", lambda a, x, most: x[0] * a / most),
    AmplitudeLaw("threshold", "linear beyond a0", _threshold, (1.0, 0.2), (0.0, 0.0), (20.0, 0.95)),
)
"""x[0] is the exponent at the largest amplitude (of the threshold law the slope there), so of the order of 1 for all.

Sources: Gaussian, paper, eq. 1; exponential, the closure of rough contact mu/mu0 = exp(-u/sigma) (physics/rough_contact
has its parameters); threshold, intermittent contact that begins once the plate leaves the skin (form assumed)."""


class LawFit(NamedTuple):
    """One law, fitted."""

    name: str
    words: str
    aic: float
    """N log(S/N) - segments log(1 - rho^2) + 2k, S the sum of squares less what one residual tells of the next."""
    x: tuple[float, ...]
    """log f0 at 0.5 N, exponent of the load, growth in contact, share of the effect lost to moisture, log of the time
    in which that happens, the law's own."""
    residual: float
    """rms of what is left of log friction."""
    carried: float
    """Correlation rho of neighbouring residuals."""


def wet_share(contact_s: Array, log_time: float) -> Array:
    """Return w = 1 - exp(-t/T), how far moisture has built up in contact."""
    return np.asarray(-np.expm1(-contact_s / math.exp(log_time)))


def relative_load(pieces: Pieces) -> Array:
    """Return log(N/0.5 N) of each piece."""
    return np.asarray(pieces.log_load - np.log(REFERENCE_LOAD_N))


def fit_law(law: AmplitudeLaw, pieces: Pieces, largest_um: float) -> tuple[LawFit, Array, float]:
    """Return a law's fit, the standard errors of its parameters, and their degrees of freedom."""
    relative, count = relative_load(pieces), pieces.contact_s.size
    middles, widths = np.array(list(PRIORS.values())).T
    known = np.arange(1, FIXED)

    def left(x: Array) -> Array:
        wet = wet_share(pieces.contact_s, x[4])
        exponent = law.exponent(pieces.amplitude_um, x[FIXED:], largest_um)
        share = np.log(np.mean(np.exp(-exponent * (1 - x[3] * wet)[:, None]), axis=1))
        return np.asarray(pieces.log_friction - x[0] - x[1] * relative - np.log1p(x[2] * wet) - share)

    def whitened(x: Array, rho: float, sigma: float) -> Array:
        r = left(x)
        first = np.sqrt(1 - rho**2) * r
        rows = np.where(pieces.follows, r - rho * np.concatenate([[0.0], r[:-1]]), first)
        return np.concatenate([rows, sigma * (x[known] - middles) / widths])

    x = np.array([float(np.mean(pieces.log_friction)), *middles, *law.start])
    low = np.array([-np.inf, -2.0, -0.95, -1.0, 0.0, *law.low])
    high = np.array([np.inf, 4.0, 30.0, 0.95, 6.0, *law.high])
    rho, sigma = 0.0, 0.1
    for _ in range(3):
        fit = least_squares(whitened, x, args=(rho, sigma), bounds=(low, high), x_scale=0.1, ftol=1e-6, xtol=1e-6)
        x, r = fit.x, left(fit.x)
        both = pieces.follows[1:]
        rho = float(np.clip(np.sum((r[1:] * r[:-1])[both]) / max(np.sum((r[:-1] ** 2)[both]), 1e-300), 0.0, 0.98))
        squares = float(np.sum(whitened(x, rho, sigma)[:count] ** 2))
        sigma = max(float(np.sqrt(squares / count)), 1e-9)
    freedom = max(count * (1 - rho) / (1 + rho) - x.size, 1.0)
    errors = sigma * np.sqrt(np.diag(np.linalg.pinv(fit.jac.T @ fit.jac)))
    segments = int(np.count_nonzero(~pieces.follows))
    aic = count * np.log(squares / count) - segments * np.log(1 - rho**2) + 2 * (x.size + 2)
    rms = float(np.sqrt(np.mean(r**2)))
    return LawFit(law.name, law.words, float(aic), tuple(x.tolist()), rms, rho), errors, freedom
