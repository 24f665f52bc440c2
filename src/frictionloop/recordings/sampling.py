"""When samples were taken, whether their times rise in equal steps, and how they are brought to another rate."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from frictionloop.findings import Finding
from frictionloop.quantities import Array, FrictionloopError, must_be
from frictionloop.quantities.timestamp_jitter import MISSING
from frictionloop.quantities.units import UNITS
from frictionloop.quantities.value_checks import ABOVE_0, number
from frictionloop.recordings.contents import Channel, blocks_of

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


def resampling(times_s: Array, resample_hz: float) -> Finding:
    """Return that samples at uneven times are brought to even ones: how far apart they were, and what that loses."""
    apart_ms = 1e3 * np.diff(times_s)
    more = {
        "gaps": int(np.count_nonzero(apart_ms > MISSING * np.median(apart_ms))),
        "samples": times_s.size,
        "least_apart_ms": float(apart_ms.min()),
        "most_apart_ms": float(apart_ms.max()),
    }
    return Finding("RESAMPLED", value=resample_hz, unit="Hz", limit=mean_rate(times_s) / 10, more=more)


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


AGREE = 1e-3
"""How far two rates may be apart and still be the same, as a share."""
UNEVEN = 0.1
"""A step of time that is off by more than this share, and no gap, is uneven; smaller ones are jitter (assumed)."""
SLOWEST_HZ, FASTEST_HZ = 100.0, 1e6
"""Rates outside of which times without a unit are not taken to be in s: no force is recorded so (assumed)."""


class Sampling(NamedTuple):
    """When samples were taken."""

    rate_hz: float | None
    """None: the file is a plain table."""
    source: str
    """Where the rate comes from."""
    gaps: tuple[tuple[int, int], ...] = ()
    """Row before each gap in the times, and how many samples are missing there."""
    uneven_s: float = 0.0
    """By how much the worst of the other steps of time is off the usual one; 0 where they are equal."""

    @property
    def even(self) -> bool:
        """Whether the times rise in equal steps, but for gaps."""
        return not self.uneven_s


def sampling_of(path: str, channels: Sequence[Channel], rate_hz: float | None = None) -> Sampling:
    """Return when some channels were taken, all of them at one rate.

    Raises
    ------
    FrictionloopError
        For two rates none of which is given, or one that is given against the file.
    """
    if rate_hz is not None:
        number("rate_hz", rate_hz, "Hz", ABOVE_0)
    told = told_by(channels)
    steps = Sampling(None, "told nowhere")
    for times in {id(each.times): each.times for each in channels if each.times is not None}.values():
        steps = steps_of(times, next(iter(told.values()), rate_hz))
        if steps.rate_hz is not None:
            told[steps.source] = steps.rate_hz
    found = one_rate(path, told, rate_hz, loose=not steps.even)
    by, hertz = found or ("told nowhere", None)
    return Sampling(hertz, by, steps.gaps, steps.uneven_s)


def samplings_of(path: str, channels: Sequence[Channel], rate_hz: float | None = None) -> dict[str, Sampling]:
    """Return when each of some channels was taken, by its name."""
    alike: dict[tuple[object, ...], Sampling] = {}
    found = {}
    for each in channels:
        kind = (*each.rates_hz.items(), id(each.times))
        if kind not in alike:
            alike[kind] = sampling_of(path, [each], rate_hz)
        found[each.name] = alike[kind]
    return found


def told_by(channels: Sequence[Channel]) -> dict[str, float]:
    """Return what the file says of the rates of channels, by where; two places of one name with their channels."""
    told: dict[str, float] = {}
    for each in channels:
        for where, hertz in each.rates_hz.items():
            told[where if told.get(where, hertz) == hertz else f"{where} of {each.name!r}"] = hertz
    return told


def one_rate(
    path: str, told: Mapping[str, float], given_hz: float | None, loose: bool = False
) -> tuple[str, float] | None:
    """Return what tells the rate, and the rate in Hz; None where nothing does.

    One that is given settles what the file leaves open, by two rates or by times that are uneven (``loose``).
    """
    first = next(iter(told.values()), None)
    differ = first is not None and any(abs(each - first) > AGREE * first for each in told.values())
    if given_hz is not None:
        near = [where for where, each in told.items() if abs(each - given_hz) <= AGREE * given_hz]
        if first is not None and not near and not differ and not loose:
            raise must_be(f"{path}: rate_hz", float(given_hz), f"{first:g}, as in the file, or none", "Hz")
        return f"given, as {near[0]} says" if near else "given", float(given_hz)
    if first is not None and differ:
        says = ", ".join(f"{each:.6g} Hz by {where}" for where, each in told.items())
        raise must_be(f"{path}: rate_hz", says, "one, or given")
    return None if first is None else (" and ".join(told), first)


def steps_of(times: Channel, near_hz: float | None) -> Sampling:
    """Return what times tell, no rate if they are counts; those without a unit are in s, or in ms or us near a rate."""
    source = f"the column {times.name!r}"
    usual, total, inside, row, worst = 0.0, 0.0, 0, 0, 0.0
    missing: list[tuple[int, int]] = []
    last = np.zeros(0)
    for block in blocks_of(times.samples):
        steps = np.diff(np.concatenate([last, np.asarray(block, dtype=float)]))
        last, start = np.asarray(block[-1:], dtype=float), max(row - 1, 0)
        row += block.size
        usual = usual or (float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0)
        if not usual > 0:
            return Sampling(None, source, (), abs(usual) or float(np.isfinite(steps).any()))
        near = np.abs(steps - usual) <= UNEVEN * usual
        off = np.flatnonzero(~near)
        jumps = steps[off] / usual
        missing += [(start + int(k), round(jump) - 1) for k, jump in zip(off, jumps, strict=True) if jump >= MISSING]
        worst = max(worst, float(np.abs(np.nan_to_num(jumps[~(jumps >= MISSING)]) - 1).max(initial=0.0)))
        total, inside = total + float(steps[near].sum()), inside + int(near.sum())
    off_s, usual = worst * usual, total / inside if inside else usual
    factors = [each for each in (1.0, 1e-3, 1e-6) if near_hz and abs(usual * each * near_hz - 1) <= AGREE]
    if times.unit in UNITS:
        factors = [UNITS[str(times.unit)][1]]
    elif not factors and not may_be_seconds(usual):
        return Sampling(None, source, tuple(missing), off_s)
    factor = (factors or [1.0])[0]
    return Sampling(float(f"{1 / (factor * usual):.9g}"), source, tuple(missing), factor * off_s)


def may_be_seconds(step: float) -> bool:
    """Tell whether times without a unit that rise by this may be in s."""
    return step > 0 and SLOWEST_HZ * (1 - AGREE) <= 1 / step <= FASTEST_HZ * (1 + AGREE)


def in_seconds(times: Channel) -> Array:
    """Return times in s, which those without a unit are taken to be in; dates in whole units count from the first."""
    values = np.asarray(times.samples)
    if values.dtype.kind in "iu" and values.size and abs(int(values[0])) > 2**52:
        values = values - values[0]
    return np.asarray(UNITS.get(times.unit or "s", ("", 1.0))[1] * values.astype(float))


def usual_step(in_s: Array) -> float:
    """Return the step that most times have, 0 where there is none."""
    steps = np.diff(in_s)
    return float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0
