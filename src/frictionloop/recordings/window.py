"""On which clock `start_s` and `stop_s` count: that of the file's times if it has any, else from the first sample."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import must_be
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.contents import Array, Channel
from frictionloop.recordings.sampling import in_seconds, may_be_seconds, usual_step
from frictionloop.recordings.straight_lines import UNTOLD, tells_seconds

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


def clock_to_resample(where: str, times: Channel | None, resample_hz: float) -> Clock:
    """Return the clock of times that are to be brought to even ones; refuses such as cannot be."""
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
    return clock


def rows_between(recording: Recording, clock: Clock) -> tuple[int, int]:
    """Return the first row in use and the one behind the last, both near the times that are asked for.

    ``start_s = 0`` of a file whose times begin later is its beginning.
    """
    at_s, usual_s, begins_s = clock
    end_s = float(np.nanmax(at_s))
    given = {"start_s": recording.start_s, "stop_s": recording.stop_s}
    if recording.start_s == 0 and begins_s > 0:
        given["start_s"] = None
    ends = {"start_s": end_s, "stop_s": end_s + usual_s}
    rows = {"start_s": 0, "stop_s": at_s.size - 1}
    low_s, high_s = (given[name] for name in given)
    near = at_s >= (-np.inf if low_s is None else low_s - usual_s / 2)
    found = np.flatnonzero(near & (at_s <= (np.inf if high_s is None else high_s + usual_s / 2)))
    for (name, value), at in zip(given.items(), (0, -1), strict=True):
        if value is None:
            continue
        if not begins_s - usual_s / 2 <= value <= ends[name] + usual_s / 2:
            raise must_be(f"{recording.path}: {name}", float(value), f"from {begins_s:.9g} to {end_s:.9g}", "s")
        if not found.size or abs(at_s[found[at]] - value) > 1.6 * usual_s:
            known_s = at_s[np.isfinite(at_s)]
            before = known_s[known_s < value].max(initial=begins_s)
            after = known_s[known_s > value].min(initial=end_s)
            accepted = f"a time with a row, not from {before:.9g} to {after:.9g}"
            raise must_be(f"{recording.path}: {name}", float(value), accepted, "s")
        rows[name] = int(found[at])
    return rows["start_s"], rows["stop_s"] + 1


def rows_counted(recording: Recording, count: int, rate_hz: float) -> tuple[int, int]:
    """Return the same of rows that are counted at a rate, from the first on."""
    path, start_s, stop_s = recording.path, recording.start_s or 0.0, recording.stop_s
    for name, value, most in (("start_s", start_s, count - 0.5), ("stop_s", stop_s or 0.0, count + 0.5)):
        beyond = value * rate_hz >= most if name == "start_s" else value * rate_hz > most
        if value < 0 or beyond:
            lasts = f"from 0 to {count / rate_hz:g}, {count} samples at {rate_hz:g} Hz"
            raise must_be(f"{path}: {name}", float(value), lasts, "s")
    return round(start_s * rate_hz), count if stop_s is None else min(round(stop_s * rate_hz) + 1, count)
