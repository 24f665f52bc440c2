"""Which rows of a file a recording takes: by their number at an even rate, by their times where rows are missing."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.steps import uneven_in
from frictionloop.recordings.clean import LEAST, longest, taking
from frictionloop.recordings.clock import EVEN, are_seconds, in_seconds, no_rate, rate_of
from frictionloop.recordings.column import Array, Column, refuse_gaps
from frictionloop.recordings.stamps import ACCEPTED


class Part(NamedTuple):
    """The rows in use."""

    first: int
    stop: int
    """The row behind the last one."""
    rate_hz: float
    by: str
    """What tells the rate."""
    since_s: float
    """Time of the first of these rows after the first row of the file, as `start_s` counts."""


def part_of(recording: Recording, column: Column) -> Part:
    """Return the rows between ``start_s`` and ``stop_s``.

    Where nothing but the times tells the rate, and rows are missing in them, both are times after the first
    one, and only the times of the part in use must be even. Else rows are counted at the rate.

    Raises
    ------
    FrictionloopError
        For times with a gap in the part in use, a part that is not there, or a rate that is missing or contradicted.
    """
    times = column.times
    if recording.rate_hz is None and column.rate_hz is None and times is not None and times.samples.size > 1:
        in_s = in_seconds(times)
        usual_s = _usual(in_s)
        if not np.isfinite(in_s).all() or uneven_in(in_s, abs(usual_s) or 1.0, EVEN):
            return _by_times(recording, times, in_s, usual_s)
    return _by_number(recording, column)


def _by_number(recording: Recording, column: Column) -> Part:
    """Return the rows counted at the rate."""
    path, count = recording.path, column.samples.size
    told_hz, by = rate_of(recording, column)
    rate_hz = told_hz or recording.rate_hz
    if rate_hz is None:
        raise FrictionloopError(f"{path}: {no_rate(column)}")
    lasts = f"the recording lasts {count / rate_hz:g} s ({count} samples at {rate_hz:g} Hz)"
    if recording.start_s * rate_hz >= count - 0.5:
        raise FrictionloopError(f"{path}: start_s = {recording.start_s:g} is beyond the end; {lasts}")
    if recording.stop_s is not None and recording.stop_s * rate_hz > count + 0.5:
        raise FrictionloopError(f"{path}: stop_s = {recording.stop_s:g} is beyond the end; {lasts}")
    first = round(recording.start_s * rate_hz)
    stop = count if recording.stop_s is None else min(round(recording.stop_s * rate_hz) + 1, count)
    return Part(first, stop, rate_hz, by if told_hz else "rate_hz, as given", first / rate_hz)


def _by_times(recording: Recording, times: Column, in_s: Array, usual_s: float) -> Part:
    """Return the rows whose times lie between both."""
    path, first, stop = recording.path, 0, in_s.size
    since_s = in_s - np.nanmin(in_s) if np.isfinite(in_s).any() else in_s
    seconds = usual_s > 0 and are_seconds(times, usual_s)
    if seconds:
        first, stop = _between(recording, since_s, usual_s)
    part_s = since_s[first:stop]

    def place(k: int) -> str:
        return times.place(first + k)

    cut = _cut(recording, since_s, first, stop, usual_s) if seconds else ""
    refuse_gaps(path, part_s, place, accepted=ACCEPTED, cut=cut)
    uneven = uneven_in(part_s, abs(usual_s) or 1.0, EVEN)
    if uneven is not None or part_s.size < 2:
        said = uneven.said(place) if uneven else "one row is no recording"
        raise FrictionloopError(
            f"{path}: {said}; accepted: even steps (most are {usual_s:g} s), or rate_hz given, with "
            f"which rows are taken one after the other{cut}"
        )
    rate_hz = float(f"{(part_s.size - 1) / (part_s[-1] - part_s[0]):.9g}")
    return Part(first, stop, rate_hz, repr(times.name), float(part_s[0]))


def _between(recording: Recording, since_s: Array, usual_s: float) -> tuple[int, int]:
    """Return the first row in use and the one behind the last, both near the times that are asked for."""
    stop_s = np.inf if recording.stop_s is None else recording.stop_s
    end_s = float(np.nanmax(since_s))
    for name, value, last_s in (("start_s", recording.start_s, end_s), ("stop_s", stop_s, end_s + usual_s)):
        if np.isfinite(value) and value > last_s + usual_s / 2:
            raise FrictionloopError(
                f"{recording.path}: {name} = {value:g} is beyond the end; the times last {end_s:g} s"
            )
    rows = np.flatnonzero((since_s >= recording.start_s - usual_s / 2) & (since_s <= stop_s + usual_s / 2))
    ends = ("start_s", recording.start_s, 0), ("stop_s", stop_s, -1)
    for name, value, at in ends:
        if np.isfinite(value) and (not rows.size or abs(since_s[rows[at]] - value) > 1.6 * usual_s):
            known_s = since_s[np.isfinite(since_s)]
            before, after = known_s[known_s < value].max(initial=0.0), known_s[known_s > value].min(initial=end_s)
            raise FrictionloopError(
                f"{recording.path}: {name} = {value:g} lies where rows are missing in the times, {before:.9g} to "
                f"{after:.9g} s; accepted: a time with a row"
            )
    first = int(rows[0]) if recording.start_s else 0
    return first, since_s.size if recording.stop_s is None else int(rows[-1]) + 1


def _cut(recording: Recording, since_s: Array, first: int, stop: int, usual_s: float) -> str:
    """Return what takes the longest part without a gap in the times; "" where that is short, or would not be it."""
    even = np.abs(np.diff(since_s[first:stop]) / usual_s - 1) <= EVEN
    start, last = longest(even)
    rows = first + start, first + last + 2  # a step has a row at both ends
    if last - start < LEAST:
        return ""
    start_s, stop_s = float(since_s[rows[0]]), float(since_s[rows[1] - 1])
    taken = recording.model_copy(update={"start_s": start_s, "stop_s": stop_s})
    return f", or {taking(start_s, stop_s)}" if _between(taken, since_s, usual_s) == rows else ""


def _usual(in_s: Array) -> float:
    steps = np.diff(in_s)
    return float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0


def rows_until(column: Column, stop: int) -> Column:
    """Return a column whose times end before a row: a gap behind the part in use does not count."""
    times = column.times
    return column if times is None else replace(column, times=replace(times, samples=times.samples[:stop]))
