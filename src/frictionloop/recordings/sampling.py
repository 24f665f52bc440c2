"""When the samples of channels were taken: what a file tells of it, and whether its times rise in equal steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from frictionloop.quantities import must_be
from frictionloop.quantities.checks import ABOVE_0, number
from frictionloop.quantities.timestamp_jitter import MISSING
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.contents import Array, Channel
from frictionloop.recordings.stored import blocks_of

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
    steps = Steps(None)
    for times in {id(each.times): each.times for each in channels if each.times is not None}.values():
        steps = steps_of(times, next(iter(told.values()), rate_hz))
        if steps.usual_s is not None:
            told[f"the column {times.name!r}"] = float(f"{1 / steps.usual_s:.9g}")
    found = one_rate(path, told, rate_hz, loose=bool(steps.uneven_s))
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


class Steps(NamedTuple):
    """The steps of a column of times."""

    usual_s: float | None
    """None of counts."""
    gaps: tuple[tuple[int, int], ...] = ()
    uneven_s: float = 0.0


def steps_of(times: Channel, near_hz: float | None) -> Steps:
    """Return the steps of times; those without a unit are in s, or in ms or us if that agrees with a rate."""
    usual, total, inside, row, worst = 0.0, 0.0, 0, 0, 0.0
    missing: list[tuple[int, int]] = []
    last = np.zeros(0)
    for block in blocks_of(times.samples):
        steps = np.diff(np.concatenate([last, np.asarray(block, dtype=float)]))
        last, start = np.asarray(block[-1:], dtype=float), max(row - 1, 0)
        row += block.size
        usual = usual or (float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0)
        if not usual > 0:
            return Steps(None, (), abs(usual) or float(np.isfinite(steps).any()))
        near = np.abs(steps - usual) <= UNEVEN * usual
        off = np.flatnonzero(~near)
        jumps = steps[off] / usual
        missing += [(start + int(k), round(jump) - 1) for k, jump in zip(off, jumps, strict=True) if jump >= MISSING]
        worst = max(worst, float(np.abs(np.nan_to_num(jumps[~(jumps >= MISSING)]) - 1).max(initial=0.0)))
        total, inside = total + float(steps[near].sum()), inside + int(near.sum())
    off_s, usual = worst * usual, total / inside if inside else usual
    if times.unit in UNITS:
        factor = UNITS[str(times.unit)][1]
        return Steps(factor * usual, tuple(missing), factor * off_s)
    for factor in (1.0, 1e-3, 1e-6):
        if near_hz is not None and abs(usual * factor * near_hz - 1) <= AGREE:
            return Steps(factor * usual, tuple(missing), factor * off_s)
    return Steps(usual if may_be_seconds(usual) else None, tuple(missing), off_s)


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
