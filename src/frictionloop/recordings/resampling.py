"""Samples at another rate, band-limited, and what a lower rate cannot hold of them."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.column import Array

_LARGEST_RATIO = 100_000  # terms of the resampling ratio: right to 10 ppm, finer than the clocks of recorders


def resampled(force: Array, file_hz: float, rate_hz: float, path: str) -> Array:
    """Return samples at another rate, band-limited and without phase shift, as `read.read_recording` says.

    Raises
    ------
    FrictionloopError
        For rates too far apart.
    """
    slower, faster = sorted((file_hz, rate_hz))
    if not 0 < faster <= _LARGEST_RATIO * slower:
        raise FrictionloopError(
            f"{path}: {file_hz:g} Hz cannot be resampled to {rate_hz:g} Hz; "
            f"accepted: {file_hz / _LARGEST_RATIO:g} to {file_hz * _LARGEST_RATIO:g} Hz"
        )
    ratio = Fraction(slower / faster).limit_denominator(_LARGEST_RATIO)
    if ratio == 1 or force.size == 1:
        return force
    from scipy.signal import firwin, kaiser_beta, resample_poly

    up, down = ratio.as_integer_ratio() if rate_hz < file_hz else ratio.as_integer_ratio()[::-1]
    # 32 samples of the lower rate to each side: 100 dB in a band of 0.2 of its Nyquist frequency.
    low_pass = firwin(64 * max(up, down) + 1, 0.9 / max(up, down), window=("kaiser", kaiser_beta(100)))
    line = np.linspace(force[0], force[-1], force.size)
    around = resample_poly(force - line, up, down, window=low_pass, padtype="antireflect")
    # The last t_k is the last one that the recording covers.
    k = np.arange((force.size - 1) * up // down + 1)
    return np.asarray(around[: k.size] + np.interp(k * (down / up), np.arange(force.size), line))


def removed_share(force: Array, file_hz: float, rate_hz: float, path: str) -> float:
    """Return which share of the variation (rms) of samples a lower rate cannot hold: 0 at their own or a higher one."""
    if rate_hz >= file_hz or not np.ptp(force):
        return 0.0
    back = resampled(resampled(force, file_hz, rate_hz, path), rate_hz, file_hz, path)
    common = slice(min(back.size, force.size))
    return min(1.0, float(np.std(force[common] - back[common]) / np.std(force[common])))
