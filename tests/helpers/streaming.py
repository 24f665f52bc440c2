"""The index D of a residual as a loop accumulates it, on an array, and how far its filter is off the thresholds."""

from __future__ import annotations

import numpy as np
from scipy.signal import sosfilt, sosfreqz

from frictionloop.perception import force_threshold_n, weighting_sos
from frictionloop.perception.weighting import GRID_HZ


def weighting_error_db(rate_hz, finger=None, frequency_hz=GRID_HZ):
    """20 log10 (|H(f)| F_th(f))."""
    gain = np.abs(sosfreqz(weighting_sos(rate_hz, finger), np.ravel(frequency_hz), fs=rate_hz)[1])
    return 20 * np.log10(gain.reshape(np.shape(frequency_hz)) * force_threshold_n(frequency_hz, finger))


def settled_state(sos, first_n):
    """State after a constant residual: the high-pass blocks it, with s1 = -b0 x and s2 = b2 x; all others hold 0."""
    state = np.zeros((len(sos), 2))
    state[0] = -sos[0, 0] * first_n, sos[0, 2] * first_n
    return state


def weighted_residual(residual_n, rate_hz, finger=None):
    """The residual in units of its threshold, from a filter that is settled on the first sample."""
    sos = weighting_sos(rate_hz, finger)
    return sosfilt(sos, residual_n, zi=settled_state(sos, residual_n[0]))[0]


def streaming_index(residual_n, rate_hz, finger=None, skip_s=0.0):
    """The rms of the filtered samples after the first ones."""
    return np.sqrt(np.mean(np.square(weighted_residual(residual_n, rate_hz, finger)[round(skip_s * rate_hz) :])))
