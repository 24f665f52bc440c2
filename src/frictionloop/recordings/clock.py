"""Columns of times: the rate that they tell, and that none of them is taken for a force."""

from __future__ import annotations

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import must_be
from frictionloop.quantities.timestamp_jitter import uneven_in
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.column import DEFAULT, Array, Column, no_column
from frictionloop.recordings.headers import is_time

SLOWEST_HZ, FASTEST_HZ = 100.0, 1e6
"""Rates outside of which times without a unit are not taken to be in s: no force is recorded so (assumed)."""
EVEN = 1e-3
"""How far a step of time may be off, as a share."""
_NEAR = 0.1
"""How far a rate that is given may be from that of uneven times, as a share: jitter and lost rows (assumed)."""


def refuse_times(recording: Recording, column: Column) -> None:
    """Refuse a column that is called a time, or one given by number that rises as no measured force does.

    With a unit given beside its number it is what the unit says.
    """
    guessed = recording.column.strip().isdecimal() and recording.unit is None and bool(column.others)
    guessed = guessed and column.times is None and column.rate_hz is None  # who tells the rate needs no times
    if is_time(column.name) or (guessed and _rises_evenly(column.samples)):
        default = f"{DEFAULT} " if recording.column == Recording.model_fields["column"].default else ""
        raise no_column(recording, list(column.others) or ["a force"], f"{default}holds times")


def _rises_evenly(values: Array) -> bool:
    steps = np.diff(values[:1000].astype(float))
    return steps.size > 1 and bool(steps.min() > 0) and bool(np.ptp(steps) <= 2 * EVEN * steps.mean())


def may_be_seconds(step: float) -> bool:
    """Tell whether times without a unit that rise by this may be in s."""
    return step > 0 and SLOWEST_HZ * (1 - EVEN) <= 1 / step <= FASTEST_HZ * (1 + EVEN)


def in_seconds(times: Column) -> Array:
    """Return times in s, which those without a unit are taken to be in."""
    return np.asarray(UNITS.get(times.unit or "s", ("", 1.0))[1] * np.asarray(times.samples, dtype=float))


def are_seconds(times: Column, step_s: float, given_hz: float | None = None) -> bool:
    """Tell whether times that rise by this are in s, and no counts of samples; a rate that is theirs in s tells it."""
    told = given_hz is not None and abs(given_hz * step_s - 1) <= _NEAR
    return times.unit in UNITS or may_be_seconds(step_s) or told


def rate_of(recording: Recording, column: Column) -> tuple[float | None, str]:
    """Return the rate in Hz that the times of a file, its format or an attribute tell, and what tells it.

    Uneven times give way to a rate that is given, if it is near theirs.

    Raises
    ------
    FrictionloopError
        For a rate that contradicts the times.
    """
    given_hz, times, told_hz, by = recording.rate_hz, column.times, column.rate_hz, column.rate_by
    known_hz = told_hz if given_hz is None else given_hz
    found_hz = None if times is None or times.samples.size < 2 else _rate_of(recording.path, times, known_hz)
    if times is not None and found_hz is not None and told_hz is not None and abs(told_hz - found_hz) > EVEN * told_hz:
        said = f"{found_hz:g} Hz by {times.name!r}, {told_hz:g} Hz by {by}"
        raise must_be(f"{recording.path}: rate_hz", said, "one rate")
    if times is not None and found_hz is not None:
        by = repr(times.name)
    found_hz = told_hz if found_hz is None else found_hz
    if given_hz is not None and found_hz is not None and abs(given_hz - found_hz) > EVEN * found_hz:
        raise must_be(f"{recording.path}: rate_hz", given_hz, f"{found_hz:g}, as in the file, or none", "Hz")
    return found_hz, by


def unevenness(column: Column, rate_hz: float) -> str:
    """Return where the times of a file do not rise by a period of the rate that is given, "" where all do.

    The rows are then taken one after the other: those after a gap come too early, by what the gap is longer.
    """
    times = column.times
    if times is None or times.samples.size < 2:
        return ""
    in_s = in_seconds(times)
    steps = np.diff(in_s)
    if not np.isfinite(steps).any():
        return f"times are not read: {times.place(0)}"
    usual = float(np.nanmedian(steps))
    if not are_seconds(times, usual, rate_hz):
        return f"{times.name!r} has no unit, steps of {usual:g}: {_rows_apart(rate_hz)}"
    uneven = uneven_in(in_s, 1 / rate_hz, _NEAR)
    if uneven is None:
        return ""
    off_s = np.nanmax(np.abs(in_s - in_s[0] - np.arange(in_s.size) / rate_hz))
    return f"{uneven.describe(times.place)}; {_rows_apart(rate_hz)}, at most {off_s:.3g} s off"


def _rows_apart(rate_hz: float) -> str:
    return f"rows are taken {1 / rate_hz:g} s apart"


def _in_seconds_after_all(step: float, rate_hz: float) -> bool:
    """Tell whether times without a unit may be in s of a slow recording, and at a rate are neither that nor counts."""
    whole = step == round(step)
    as_given = any(abs(unit_s * rate_hz * step - 1) <= _NEAR for unit_s in (1.0, 1e-3))
    return not whole and not as_given and 1.0 < 1 / step < SLOWEST_HZ


def no_rate(column: Column) -> str:
    """Return the line that says a file does not tell its rate."""
    why = ""
    if column.times is not None and column.times.samples.size > 1:
        hertz = 1 / float(np.nanmedian(np.diff(np.asarray(column.times.samples, dtype=float))))
        other = f", in ms {1e3 * hertz:g} Hz" if hertz < SLOWEST_HZ else ""
        why = f", {column.times.name!r} without a unit: in s {hertz:g} Hz{other}"
    return f"rate_hz is missing{why}; accepted: --disturbance.rate_hz, or a column 'time_s' or 'Time [ms]'"


def _rate_of(path: str, times: Column, given_hz: float | None) -> float | None:
    """Return the rate of times, None if they are counts, or uneven about the rate that is given."""
    in_s = in_seconds(times)
    steps = np.diff(in_s)
    if not np.any(np.isfinite(steps)):
        return None
    usual = float(np.nanmedian(steps))
    counts = usual != 0 and not are_seconds(times, abs(usual))
    if counts and given_hz is not None and _in_seconds_after_all(usual, given_hz):
        near = f"near {1 / usual:.4g} ({times.name!r} in s) or {1e3 / usual:.4g} (in ms), or resample_hz"
        raise must_be(f"{path}: rate_hz", given_hz, near, "Hz")
    uneven = uneven_in(in_s, abs(usual) or 1.0, EVEN)
    if uneven is None:
        return None if counts else float(f"{(in_s.size - 1) / (in_s[-1] - in_s[0]):.9g}")
    mean = float(np.nanmax(in_s) - np.nanmin(in_s)) / (in_s.size - 1)
    if given_hz is not None and not counts and not any(abs(given_hz * step - 1) <= _NEAR for step in (usual, mean)):
        raise must_be(f"{path}: rate_hz", given_hz, f"near that of the times, {1 / usual:g}", "Hz")
    return None
