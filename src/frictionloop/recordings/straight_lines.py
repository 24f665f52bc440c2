"""A force brought to another rate: band-limited from even times, by straight lines from uneven ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np

from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.timestamp_jitter import MISSING
from frictionloop.recordings.column import Array

LONGEST_STEP = 10.0
"""A longer time without samples, in usual steps, is a hole that no straight line fills (assumed)."""
UNTOLD = 10.0
"""How far apart the rate that is asked for and that of times without a unit may be for these to be s (assumed)."""
_LARGEST_RATIO = 100_000  # terms of the resampling ratio: right to 10 ppm, finer than the clocks of recorders


def even_times(where: str, times_s: Array, resample_hz: float, place: Callable[[int], str] = "row {}".format) -> Array:
    """Return even times from the first of some times that rise on, for `numpy.interp`.

        t_k = t_0 + k/f,   y(t_k) = y_i + (y_(i+1) - y_i) (t_k - t_i)/(t_(i+1) - t_i)

    A sine of frequency f_y between samples that are T apart loses up to (pi f_y T)^2/2 of its height.
    """
    steps = np.diff(times_s)
    bad = np.flatnonzero(~(steps > 0))
    if bad.size:
        at = place(int(bad[0]) + 1)
        raise must_be(f"{where}: times at {at}", "falling", "rising for resample_hz")
    usual_s, mean_hz = float(np.median(steps)), mean_rate(times_s)
    if resample_hz < (1 - 1e-3) * mean_hz:
        raise must_be(f"{where}: resample_hz", float(resample_hz), f"at least {mean_hz:.4g}, the mean rate", "Hz")
    longest = int(np.argmax(steps))
    if steps[longest] > LONGEST_STEP * usual_s:
        most = f"at most {LONGEST_STEP * usual_s:.3g} for resample_hz"
        raise must_be(f"{where}: gap after {place(longest)}", float(f"{steps[longest]:.3g}"), most, "s")
    last = int((times_s[-1] - times_s[0]) * resample_hz * (1 + 1e-12))
    return np.asarray(times_s[0] + np.arange(last + 1) / resample_hz)


def mean_rate(times_s: Array) -> float:
    """Return the mean rate in Hz of times that rise."""
    return (times_s.size - 1) / float(times_s[-1] - times_s[0])


def tells_seconds(times: Array, resample_hz: float) -> bool:
    """Tell whether times without a unit are in s, by the rate that they are to be brought to."""
    first, last = times[np.isfinite(times)][[0, -1]] if np.isfinite(times).any() else (0.0, 0.0)
    mean_hz = (times.size - 1) / (last - first) if last > first else 0.0
    return resample_hz / UNTOLD <= mean_hz <= resample_hz * UNTOLD


def offer(times_s: Array) -> str:
    """Return the flag that brings uneven times to even ones; "" for such as could not be brought there."""
    steps = np.diff(times_s)
    if not steps.size or not np.all(steps > 0) or steps.max() > LONGEST_STEP * np.median(steps):
        return ""
    flag = f"--disturbance.resample_hz {math.ceil(mean_rate(times_s))} (or --setpoint)"
    return f"{flag}, or "


def described(times_s: Array) -> tuple[str, str]:
    """Return in words how far samples are apart, and what straight lines between them lose."""
    steps = np.diff(times_s)
    over = int(np.count_nonzero(steps > MISSING * np.median(steps)))
    gaps = f", over {over} gap{'s' * (over > 1)} of up to {1e3 * steps.max():.3g} ms" if over else ""
    apart = f"{times_s.size} samples, {1e3 * steps.min():.3g} to {1e3 * steps.max():.3g} ms apart{gaps}"
    loses = f"straight lines: {mean_rate(times_s) / 10:.3g} Hz loses up to 5 %"
    return apart, loses


def resampled(force: Array, file_hz: float, rate_hz: float, path: str) -> Array:
    """Return samples at another rate, band-limited and without phase shift, as `read.read_recording` says."""
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
