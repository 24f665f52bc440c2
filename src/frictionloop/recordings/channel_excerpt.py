"""Which rows of a channel a recording takes, on which clock, and at which rate."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.findings import Finding
from frictionloop.parameters.input_signals import Recording
from frictionloop.quantities import Array, FrictionloopError, must_be
from frictionloop.quantities.timestamp_jitter import uneven_in
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.contents import Channel
from frictionloop.recordings.friction_defects import LEAST, longest, refuse_gaps, taking
from frictionloop.recordings.sampling import (
    SLOWEST_HZ,
    UNTOLD,
    even_times,
    in_seconds,
    may_be_seconds,
    offer,
    one_rate,
    resampling,
    tells_seconds,
    told_by,
    usual_step,
)
from frictionloop.recordings.text_numbers import ACCEPTED

NEAR = 0.1
"""How far a rate that is given may be from that of uneven times, as a share: jitter and lost rows (assumed)."""

ABSOLUTE_S = 1e8
"""Times beyond this, three years, are dates (s since 1970 or 1904), from the first of which a part counts (assumed)."""


class Clock(NamedTuple):
    """Times of the rows in s, as `start_s` and `stop_s` count."""

    at_s: Array
    """NaN where there is none."""
    usual_s: float
    """The step that most have."""
    begins_s: float
    """The first time."""

    @property
    def mean_hz(self) -> float:
        """The mean rate; one that was a round number is one again."""
        return float(f"{(self.at_s.size - 1) / (self.at_s[-1] - self.at_s[0]):.9g}")

    def is_near(self, rate_hz: float) -> bool:
        """Return whether a rate is about that of the usual step, or of the mean one."""
        mean_s = float(np.nanmax(self.at_s) - np.nanmin(self.at_s)) / (self.at_s.size - 1)
        return any(abs(rate_hz * step_s - 1) <= NEAR for step_s in (self.usual_s, mean_s))

    @property
    def rises(self) -> bool:
        """Whether no time is earlier than one before."""
        known = self.at_s[np.isfinite(self.at_s)]
        return bool(np.all(np.diff(known) >= 0))


def clock_of(times: Channel | None, given_hz: float | None = None) -> Clock | None:
    """Return the clock of a column of times; None without one in s, to which a rate that is given may help.

    Dates, as ISO 8601 or as seconds since 1970 or 1904, count from the first of them.
    """
    if times is None or times.samples.size < 2:
        return None
    in_s = in_seconds(times)
    usual_s = usual_step(in_s)
    near = given_hz is not None and abs(given_hz * usual_s - 1) <= NEAR
    if not (usual_s > 0 and (times.unit in UNITS or may_be_seconds(usual_s) or near)):
        return None
    first_s = float(in_s[np.isfinite(in_s)][0])
    zero_s = first_s if abs(first_s) > ABSOLUTE_S else 0.0
    return Clock(in_s - zero_s, usual_s, first_s - zero_s)


def clock_to_resample(where: str, times: Channel | None, resample_hz: float) -> tuple[Channel, Clock]:
    """Return times that are to be brought to even ones, and their clock; refuses such as cannot be."""
    if times is None or times.samples.size < 2:
        raise must_be(f"{where}: column of times", None, "resample_hz needs it")
    in_s = in_seconds(times)
    usual_s = usual_step(in_s)
    if not usual_s > 0:
        raise must_be(f"{where}: usual step of {times.name!r}", usual_s, "above 0 for resample_hz", "s")
    clock = clock_of(times, 1 / usual_s if tells_seconds(in_s, resample_hz) else None)
    if clock is None:
        accepted = f"told by a name such as 'time_s', or a rate within {UNTOLD:g} x {1 / usual_s:.3g} Hz"
        raise must_be(f"{where}: unit of {times.name!r}", times.unit, accepted)
    return times, clock


def rows_between(recording: Recording, clock: Clock) -> tuple[int, int]:
    """Return the first row in use and the one behind the last, both near the times that are asked for.

    ``start_s = 0`` of a file whose times begin later is its beginning.
    """
    at_s, usual_s, begins_s = clock
    end_s = float(np.nanmax(at_s))
    start_s, stop_s = recording.start_s, recording.stop_s
    if start_s == 0 and begins_s > 0:
        start_s = None
    near = at_s >= (-np.inf if start_s is None else start_s - usual_s / 2)
    found = np.flatnonzero(near & (at_s <= (np.inf if stop_s is None else stop_s + usual_s / 2)))
    rows = [0, at_s.size - 1]
    for at, name, value, most_s in ((0, "start_s", start_s, end_s), (-1, "stop_s", stop_s, end_s + usual_s)):
        if value is None:
            continue
        if not begins_s - usual_s / 2 <= value <= most_s + usual_s / 2:
            raise must_be(f"{recording.path}: {name}", float(value), f"from {begins_s:.9g} to {end_s:.9g}", "s")
        if not found.size or abs(at_s[found[at]] - value) > 1.6 * usual_s:
            known_s = at_s[np.isfinite(at_s)]
            before = known_s[known_s < value].max(initial=begins_s)
            after = known_s[known_s > value].min(initial=end_s)
            accepted = f"a time with a row, not from {before:.9g} to {after:.9g}"
            raise must_be(f"{recording.path}: {name}", float(value), accepted, "s")
        rows[at] = int(found[at])
    return rows[0], rows[1] + 1


EVEN = 1e-3
"""How far a step of time may be off, as a share."""


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
    even_s: Array | None = None
    """Even times that samples at uneven ones are brought to, where that is asked for."""
    findings: tuple[Finding, ...] = ()
    """What was done to times, or is not right of them."""


def part_of(recording: Recording, channel: Channel) -> Part:
    """Return the rows between ``start_s`` and ``stop_s``, which are times of the file where it has any.

    Where nothing but the times tells the rate, only those of the part in use must be even.
    """
    path, given_hz, told, times = recording.path, recording.rate_hz, told_by([channel]), channel.times
    if recording.resample_hz is not None:
        return _by_times(recording, *clock_to_resample(path, times, recording.resample_hz))
    near_hz = given_hz or next(iter(told.values()), None)
    clock = clock_of(times, near_hz)
    if clock is not None and uneven_in(clock.at_s, clock.usual_s, EVEN) is None:
        told = {repr(times.name if times else ""): clock.mean_hz} | told
    elif clock is not None and near_hz is None and times is not None:
        return _by_times(recording, times, clock)
    elif clock is not None and near_hz is not None and not clock.is_near(near_hz):
        raise must_be(f"{path}: rate_hz", near_hz, f"near that of the times, {1 / clock.usual_s:g}", "Hz")
    elif clock is None and times is not None and times.samples.size > 1:
        _refuse_slow(path, times, given_hz)
        forced = Clock(in_seconds(times), abs(usual_step(in_seconds(times))) or 1.0, 0.0)
        if near_hz is None and uneven_in(forced.at_s, forced.usual_s, EVEN):
            return _by_times(recording, times, forced)
    if (found := one_rate(path, told, given_hz)) is None:
        raise FrictionloopError(f"{path}: {_no_rate(times)}")
    by, rate_hz = found
    if clock is None or not clock.rises:
        clock = Clock(np.arange(channel.samples.size) / rate_hz, 1 / rate_hz, 0.0)
    first, stop = rows_between(recording, clock)
    off = () if given_hz is None else _uneven(clock.at_s[:stop], rate_hz)
    return Part(first, stop, rate_hz, by, clock.at_s[first:stop], None, off)


def _uneven(at_s: Array, rate_hz: float) -> tuple[Finding, ...]:
    """Return that rows are taken one after the other at a rate that is given, and how far from their times."""
    if uneven_in(at_s, 1 / rate_hz, NEAR) is None:
        return ()
    off_s = float(np.nanmax(np.abs(at_s - at_s[0] - np.arange(at_s.size) / rate_hz)))
    return (Finding("TIMES-UNEVEN", value=1e3 * off_s, unit="ms", remedy="resample_hz"),)


def _by_times(recording: Recording, times: Channel, clock: Clock) -> Part:
    """Return the rows whose times lie between both, if those are even or are to be brought to even ones."""
    path, resample_hz = recording.path, recording.resample_hz
    if not np.isfinite(clock.at_s).any():
        refuse_gaps(path, clock.at_s, times.place, accepted=ACCEPTED)
    first, stop = rows_between(recording, clock)
    at_s, cut = clock.at_s[first:stop], "" if resample_hz else _cut(recording, clock, first, stop)

    def place(k: int) -> str:
        return times.place(first + k)

    refuse_gaps(path, at_s, place, accepted=ACCEPTED, cut=cut)
    if resample_hz is not None:
        even_s = even_times(path, at_s, resample_hz, place)
        return Part(first, stop, resample_hz, "resample_hz", at_s, even_s, (resampling(at_s, resample_hz),))
    uneven = uneven_in(at_s, clock.usual_s, EVEN)
    if uneven is not None or at_s.size < 2:
        said = uneven.describe(place) if uneven else "one row"
        as_s = f" if {times.name!r} is in s" * (times.unit is None)
        accepted = f"steps of {clock.usual_s:g} s{as_s}, {offer(at_s)}rate_hz given{cut}"
        raise FrictionloopError(f"{path}: {said}; accepted: {accepted}")
    return Part(first, stop, clock._replace(at_s=at_s).mean_hz, repr(times.name), at_s)


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


def _refuse_slow(path: str, times: Channel, given_hz: float | None) -> None:
    """Refuse a rate beside times without a unit that may be slow ones in s, and at it are neither in s nor in ms."""
    step = usual_step(in_seconds(times))
    as_given = given_hz is None or any(abs(unit_s * given_hz * step - 1) <= NEAR for unit_s in (1.0, 1e-3))
    if not as_given and step > 0 and step != round(step) and 1.0 < 1 / step < SLOWEST_HZ:
        near = f"near {1 / step:.4g} ({times.name!r} in s) or {1e3 / step:.4g} (in ms), or resample_hz"
        raise must_be(f"{path}: rate_hz", given_hz, near, "Hz")


def _no_rate(times: Channel | None) -> str:
    """Return the line that says a file does not tell its rate."""
    why = ""
    if times is not None and (usual := usual_step(in_seconds(times))):
        other = f", in ms {1e3 / usual:g} Hz" if 1 / usual < SLOWEST_HZ else ""
        why = f", {times.name!r} without a unit: in s {1 / usual:g} Hz{other}"
    return f"rate_hz is missing{why}; accepted: --disturbance.rate_hz, or a column 'time_s' or 'Time [ms]'"
