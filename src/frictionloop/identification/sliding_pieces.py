"""A recording of a finger on a vibrating plate as short pieces: friction, load, time in contact, amplitudes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.signal import lfilter, savgol_filter

from frictionloop.identification.recording_columns import READING, channel, rate_of
from frictionloop.quantities import must_be

Array = NDArray[np.float64]
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
    edges = np.flatnonzero(np.diff(np.concatenate([[False], slides, [False]]).astype(np.int8))).reshape(-1, 2)
    landed = np.maximum.accumulate(np.where(np.diff(touches, prepend=touches[0]), np.arange(touches.size), 0))
    size = max(round(piece_s * rate_hz), 4)
    rows: list[tuple[float, float, float, bool]] = []
    amplitudes: list[Array] = []
    for first, stop in edges.tolist():
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
        raise must_be(f"recording: pieces of {piece_s:g} s that slide", len(rows), f"at least {LEAST_PIECES}")
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
