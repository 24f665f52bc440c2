"""Which rows of a file a recording takes, and at which rate."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.timestamp_jitter import uneven_in
from frictionloop.recordings.clean import LEAST, longest, taking
from frictionloop.recordings.clock import EVEN, in_seconds, no_rate, rate_of
from frictionloop.recordings.column import Array, Column, refuse_gaps
from frictionloop.recordings.stamps import ACCEPTED
from frictionloop.recordings.straight_lines import UNTOLD, described, even_times, offer, tells_seconds
from frictionloop.recordings.window import Clock, clock_of, rows_between, rows_counted


class Part(NamedTuple):
    """The rows in use."""

    first: int
    stop: int
    """The row behind the last one."""
    rate_hz: float
    by: str
    """What tells the rate."""
    at_s: Array
    """Time of each of these rows, as `start_s` counts."""
    begins_s: float | None = None
    """The first time of the file, where `start_s` is one of its times; None where it counts from the first sample."""
    even_s: Array | None = None
    """Even times that samples at uneven ones are brought to, where that is asked for."""
    lost_by_lines: str = ""
    """What the straight lines between these lose."""


def part_of(recording: Recording, column: Column) -> Part:
    """Return the rows between ``start_s`` and ``stop_s``, which are times of the file where it has any.

    Where nothing but the times tells the rate, only those of the part in use must be even.
    """
    times = column.times
    if recording.resample_hz is not None:
        return _brought_to(recording, times, recording.resample_hz)
    if recording.rate_hz is None and column.rate_hz is None and times is not None and times.samples.size > 1:
        in_s = in_seconds(times)
        usual_s = _usual(in_s)
        if not np.isfinite(in_s).all() or uneven_in(in_s, abs(usual_s) or 1.0, EVEN):
            return _by_times(recording, times, in_s, usual_s)
    told_hz, by = rate_of(recording, column)
    rate_hz = told_hz or recording.rate_hz
    if rate_hz is None:
        raise FrictionloopError(f"{recording.path}: {no_rate(column)}")
    by = by if told_hz else "rate_hz, as given"
    clock = clock_of(times, rate_hz)
    if clock is None or not clock.rises:
        first, stop = rows_counted(recording, column.samples.size, rate_hz)
        return Part(first, stop, rate_hz, by, np.arange(first, stop) / rate_hz)
    first, stop = rows_between(recording, clock)
    return Part(first, stop, rate_hz, by, clock.at_s[first:stop], clock.begins_s)


def _by_times(recording: Recording, times: Column, in_s: Array, usual_s: float) -> Part:
    """Return the rows whose times lie between both, if those are even."""
    path, clock = recording.path, clock_of(times)
    first, stop = (0, in_s.size) if clock is None else rows_between(recording, clock)
    at_s = (in_s if clock is None else clock.at_s)[first:stop]

    def place(k: int) -> str:
        return times.place(first + k)

    cut = "" if clock is None else _cut(recording, clock, first, stop)
    refuse_gaps(path, at_s, place, accepted=ACCEPTED, cut=cut)
    uneven = uneven_in(at_s, abs(usual_s) or 1.0, EVEN)
    if uneven is not None or at_s.size < 2:
        said = uneven.describe(place) if uneven else "one row"
        as_s = f" if {times.name!r} is in s" * (times.unit is None)
        accepted = f"steps of {usual_s:g} s{as_s}, {offer(at_s)}rate_hz given{cut}"
        raise FrictionloopError(f"{path}: {said}; accepted: {accepted}")
    rate_hz = float(f"{(at_s.size - 1) / (at_s[-1] - at_s[0]):.9g}")
    return Part(first, stop, rate_hz, repr(times.name), at_s, None if clock is None else clock.begins_s)


def _brought_to(recording: Recording, times: Column | None, resample_hz: float) -> Part:
    """Return the rows whose times lie between both, and the even times they are brought to."""
    path = recording.path
    if times is None or times.samples.size < 2:
        raise must_be(f"{path}: column of times", None, "resample_hz needs it")
    in_s = in_seconds(times)
    usual_s = _usual(in_s)
    clock = clock_of(times, 1 / usual_s if usual_s > 0 and tells_seconds(in_s, resample_hz) else None)
    if not usual_s > 0:
        raise must_be(f"{path}: usual step of {times.name!r}", usual_s, "above 0 for resample_hz", "s")
    if clock is None:
        in_s_hz = 1 / usual_s if usual_s > 0 else math.nan
        accepted = f"told by a name such as 'time_s', or a rate within {UNTOLD:g} x {in_s_hz:.3g} Hz"
        raise must_be(f"{path}: unit of {times.name!r}", times.unit, accepted)
    first, stop = rows_between(recording, clock)
    at_s = clock.at_s[first:stop]

    def place(k: int) -> str:
        return times.place(first + k)

    refuse_gaps(path, at_s, place, accepted=ACCEPTED)
    even_s = even_times(path, at_s, resample_hz, place)
    apart, loses = described(at_s)
    by = f"straight lines between {apart}" + f", {times.name!r} taken for s" * (times.unit is None)
    return Part(first, stop, resample_hz, by, at_s, clock.begins_s, even_s, loses)


def _cut(recording: Recording, clock: Clock, first: int, stop: int) -> str:
    """Return what takes the longest part without a gap in the times; "" where that is short, or would not be it."""
    even = np.abs(np.diff(clock.at_s[first:stop]) / clock.usual_s - 1) <= EVEN
    start, last = longest(even)
    rows = first + start, first + last + 2  # a step has a row at both ends
    if last - start < LEAST:
        return ""
    start_s, stop_s = float(clock.at_s[rows[0]]), float(clock.at_s[rows[1] - 1])
    taken = recording.model_copy(update={"start_s": start_s, "stop_s": stop_s})
    try:
        return f", or {taking(start_s, stop_s)}" if rows_between(taken, clock) == rows else ""
    except FrictionloopError:  # times that go back
        return ""


def _usual(in_s: Array) -> float:
    steps = np.diff(in_s)
    return float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0


def rows_until(column: Column, stop: int) -> Column:
    """Return a column whose times end before a row: a gap behind the part in use does not count."""
    times = column.times
    return column if times is None else replace(column, times=replace(times, samples=times.samples[:stop]))
