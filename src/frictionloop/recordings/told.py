"""What was found in the file of a recording: column, unit, rate and forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings.clock import unevenness
from frictionloop.recordings.column import Column
from frictionloop.recordings.lifted_finger import off_plate
from frictionloop.recordings.part import Part
from frictionloop.recordings.read import scaled
from frictionloop.recordings.signs import Signs, signs_of


class Found(NamedTuple):
    """What was read of a recording."""

    column: str
    head: str
    """Where names and units stand, "" where there are none."""
    unit: str
    """Unit of the column."""
    unit_by: str
    """"file", "given" or "full scale"; "taken for N" where nothing tells it, and "scale" where that stands for it."""
    newtons_per_unit: float
    rate_hz: float
    rate_by: str
    """What tells the rate: the column of times, an attribute, the format, or the flag."""
    samples: int
    lowest_n: float
    highest_n: float
    """Range of the signal, in N."""
    largest_n: float
    """Largest magnitude in the file in N, before a mean is removed and an offset added."""
    mean_n: float
    """Mean of the signal in N."""
    rms_n: float
    """Standard deviation of the signal in N."""
    raw_lowest_n: float
    raw_highest_n: float
    """Range in the file in N, before a mean is removed and an offset added."""
    raw_mean_n: float
    """Mean in the file in N, before it is removed and an offset added."""
    signs: Signs
    """Whether it looks like friction with the sign of the motion, an offset added and its mean left in (`signs_of`)."""
    off_plate: str = ""
    """Stretches of it in s where the finger seems off the plate, "" without any (`contact.off_plate`)."""
    on_plate_s: tuple[float, float] | None = None
    """The longest part without such."""
    uneven: str = ""
    """Where the times are not those of a rate that is given, or what straight lines between them lose."""
    from_s: float = 0.0
    to_s: float = 0.0
    """First and last time of the part in use, as ``start_s`` counts."""
    begins_s: float | None = None
    """First of the file's times, where ``start_s`` is one of them; None where it counts from the first sample."""


def found(recording: Recording) -> Found:
    """Return what was read of a recording."""
    force, file_hz, column, part = scaled(recording, "N")
    raw = scaled(recording.model_copy(update={"remove_mean": False, "offset_n": 0.0}), "N").force
    unit, by = _unit(recording, column)
    scale = recording.scale
    largest_n, mean_n = float(np.abs(raw).max()), float(force.mean())
    zeroed = raw if recording.remove_mean else force  # an offset is that of the sensor, or a level beside a mean
    off, on_s = off_plate(zeroed, file_hz, part.at_s) or ("", None)
    return Found(
        column=_named(recording, column),
        head=column.head,
        unit=unit,
        unit_by=by,
        newtons_per_unit=UNITS.get(unit, ("N", 1.0))[1] if scale is None else scale,
        rate_hz=file_hz,
        rate_by=column.rate_by,
        samples=force.size,
        lowest_n=float(force.min()),
        highest_n=float(force.max()),
        largest_n=largest_n,
        raw_lowest_n=float(raw.min()),
        raw_highest_n=float(raw.max()),
        raw_mean_n=float(raw.mean()),
        signs=signs_of(zeroed, raw.size / file_hz),
        mean_n=0.0 if abs(mean_n) <= 1e-9 * largest_n else mean_n,  # of one that is removed its rounding is left
        rms_n=float(force.std()),
        off_plate=off,
        on_plate_s=on_s,
        uneven=_uneven(recording, column, part),
        from_s=float(part.at_s[0]),
        to_s=float(part.at_s[-1]),
        begins_s=part.begins_s,
    )


def _uneven(recording: Recording, column: Column, part: Part) -> str:
    if part.lost_by_lines:
        return part.lost_by_lines
    return "" if recording.rate_hz is None else unevenness(column, part.rate_hz)


def _named(recording: Recording, column: Column) -> str:
    """Return what a column is called, in a file of groups with its whole path and the line of it that is taken."""
    line = recording.column.partition("[")[2]
    whole = column.path + (f"[{line}" if line else "")
    return (whole if column.path else column.name) or recording.column


def _unit(recording: Recording, column: Column) -> tuple[str, str]:
    """Return the unit of a column, and what says it."""
    if recording.unit is not None:
        return known_unit(recording.unit) or recording.unit, "given"
    if column.full_scale and recording.scale is None:
        return "full scale", "full scale"
    if column.unit:
        return column.unit, "file"
    return ("N", "taken for N") if recording.scale is None else ("", "scale")
