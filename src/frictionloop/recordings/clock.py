"""Columns of times: the rate that they tell, and that none of them is taken for a force."""

from __future__ import annotations

import numpy as np

from frictionloop.parameters.sources import SLOWEST_S, Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.column import Array, Column, no_column, refuse_gaps
from frictionloop.recordings.headers import is_time

_EVEN = 1e-3
"""How far a step of time may be off, as a share."""
_NEAR = 0.1
"""How far a rate that is given may be from that of uneven times, as a share: jitter and lost rows (assumed)."""


def refuse_times(recording: Recording, column: Column) -> None:
    """Refuse a column that is called a time, or one given by number that rises as no measured force does.

    With a unit given beside its number it is what the unit says.
    """
    guessed = recording.column.strip().isdecimal() and recording.unit is None and bool(column.others)
    if is_time(column.name) or (guessed and column.times is None and _rises_evenly(column.samples)):
        default = "(the default) " if recording.column == Recording.model_fields["column"].default else ""
        raise no_column(recording, list(column.others) or ["a force"], f"{default}holds times")


def _rises_evenly(values: Array) -> bool:
    steps = np.diff(values[:1000].astype(float))
    return steps.size > 1 and bool(steps.min() > 0) and bool(np.ptp(steps) <= 2 * _EVEN * steps.mean())


def rate_of(recording: Recording, column: Column) -> float | None:
    """Return the rate in Hz that the format or the times of a file tell, None where they do not.

    Uneven times give way to a rate that is given, if it is near theirs.

    Raises
    ------
    FrictionloopError
        For times with a gap, or a rate that contradicts them.
    """
    given_hz, times = recording.rate_hz, column.times
    if times is None or times.samples.size < 2:
        found_hz = column.rate_hz
    else:
        found_hz = _rate_of(recording.path, times, given_hz)
    if given_hz is not None and found_hz is not None and abs(given_hz - found_hz) > _EVEN * found_hz:
        raise FrictionloopError(
            f"{recording.path}: rate_hz = {given_hz:g} contradicts the file, whose rate is {found_hz:g}; give none"
        )
    return found_hz


def no_rate(column: Column) -> str:
    """Return the line that says a file does not tell its rate."""
    why = "and no column of times (time, t, 'time_s', 'Time [ms]') tells it"
    if column.times is not None and column.times.samples.size > 1:
        why = f"and {column.times.name!r} has no unit: it may count samples, or be in ms"
    flags = "--disturbance.rate_hz 1000, or --setpoint.rate_hz"
    return f"rate_hz is missing, {why}; accepted: the sampling rate in Hz ({flags})"


def _rate_of(path: str, times: Column, given_hz: float | None) -> float | None:
    """Return the rate of times, None if they are counts, or uneven about the rate that is given."""
    in_s = UNITS.get(times.unit or "s", ("", 1.0))[1] * np.asarray(times.samples, dtype=float)
    if given_hz is None:
        refuse_gaps(path, in_s, times.place)
    steps = np.diff(in_s)
    if not np.any(np.isfinite(steps)):
        return None
    usual = float(np.nanmedian(steps))
    counts = times.unit not in UNITS and not abs(usual) < SLOWEST_S
    uneven = np.flatnonzero(~(np.abs(steps - usual) <= _EVEN * abs(usual)) | (steps <= 0))
    if not uneven.size:
        return None if counts else float(f"{(in_s.size - 1) / (in_s[-1] - in_s[0]):.9g}")
    if given_hz is None:
        raise FrictionloopError(
            f"{path}: {times.place(uneven[0] + 1)}, {steps[uneven[0]]:g} s after the row before: a gap; "
            f"accepted: even steps (most are {usual:g} s), or rate_hz given"
        )
    mean = float(np.nanmax(in_s) - np.nanmin(in_s)) / (in_s.size - 1)
    if not counts and not any(abs(given_hz * step - 1) <= _NEAR for step in (usual, mean)):
        raise FrictionloopError(
            f"{path}: rate_hz = {given_hz:g} contradicts the times, which rise by {usual:g} s; accepted: near theirs"
        )
    return None
