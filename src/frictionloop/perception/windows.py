"""The index D over time: what is felt in a short event, which the mean over a long run would hide."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.signal import sosfilt

from frictionloop.perception.checks import Array, number, numbers
from frictionloop.perception.thresholds import Impedance
from frictionloop.perception.weighting import settled_state, weighting_sos
from frictionloop.quantities import FrictionloopError

WINDOW_S = 1.0
"""Length of a window; 30 ms to 1 s is what the skin sums energy over (assumed, from memory)."""


def weighted_residual(residual_n: ArrayLike, rate_hz: float, finger: Impedance | None = None) -> Array:
    """Return the residual in units of its threshold: filtered by 1 / F_th, so that its rms is D.

    The filter starts settled on the first sample. A jump from there, as at the start of a run, takes 2 s to decay.

    Parameters
    ----------
    residual_n
        Force residuals in N, shape (..., samples).
    rate_hz
        Sampling rate in Hz, 1200 to 200 000.
    finger
        Impedance of the fingertip; None is `Fingertip()`.

    Raises
    ------
    FrictionloopError
        For a residual that is empty, no number or not finite, or as `weighting_sos`.
    """
    sos = weighting_sos(rate_hz, finger)
    residual = numbers("residual_n", residual_n, "N")
    if residual.ndim == 0 or residual.size == 0:
        raise FrictionloopError(f"residual_n has shape {residual.shape}: must be (..., samples), at least one")
    return np.asarray(sosfilt(sos, residual, axis=-1, zi=settled_state(sos, residual[..., 0]))[0])


def streaming_index(
    residual_n: ArrayLike, rate_hz: float, finger: Impedance | None = None, skip_s: float = 0.0
) -> Array:
    """Return D of a residual as a compiled loop accumulates it: the rms of the filtered samples after ``skip_s``.

    Within 0.45 dB of `index_of_residual` for any spectrum that lies within 1 to 500 Hz; the filter has no sharp
    edges, so what lies outside adds the little that its gain there lets through.

    Parameters
    ----------
    residual_n, rate_hz, finger
        As in `weighted_residual`.
    skip_s
        Time at the start that is filtered and not counted, in s, shorter than the record.

    Raises
    ------
    FrictionloopError
        As `weighted_residual`, or for a ``skip_s`` that is negative or leaves nothing.
    """
    weighted = weighted_residual(residual_n, rate_hz, finger)
    skip = round(number("skip_s", skip_s, "s", 0.0) * rate_hz)
    if skip >= weighted.shape[-1]:
        raise FrictionloopError(f"skip_s = {skip_s:g} s: must be below the {weighted.shape[-1] / rate_hz:g} s recorded")
    return np.asarray(np.sqrt(np.mean(np.square(weighted[..., skip:]), axis=-1)))


def windowed_index(
    residual_n: ArrayLike, rate_hz: float, finger: Impedance | None = None, window_s: float = WINDOW_S
) -> Array:
    """Return D of each window of a residual; its maximum is D of the most perceptible moment.

    Rectangular windows on the filtered residual, each overlapping the next by half. A spectrum per window would not
    do: 1 s is one period of the lowest frequency.

    Parameters
    ----------
    residual_n, rate_hz, finger
        As in `weighted_residual`.
    window_s
        Length of a window in s, at least two samples and at most the record.

    Returns
    -------
    D, shape (..., windows); window i starts at i window_s / 2, and the last ends before the record by less than that.

    Raises
    ------
    FrictionloopError
        As `weighted_residual`, or for a window that is longer than the record or shorter than two samples.
    """
    weighted = weighted_residual(residual_n, rate_hz, finger)
    recorded_s = weighted.shape[-1] / rate_hz
    length = round(number("window_s", window_s, "s", 0.0) * rate_hz)
    if not 2 <= length <= weighted.shape[-1]:
        raise FrictionloopError(
            f"window_s = {window_s:g} s: must be from {2 / rate_hz:g} to the {recorded_s:g} s recorded"
        )
    windows = np.lib.stride_tricks.sliding_window_view(np.square(weighted), length, axis=-1)[..., :: length // 2, :]
    return np.asarray(np.sqrt(windows.mean(axis=-1)))
