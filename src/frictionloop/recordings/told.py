"""What was found in the file of a recording: channel, unit, rate and forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.findings import Finding
from frictionloop.parameters.sources import Recording
from frictionloop.quantities.units import known_unit
from frictionloop.recordings.contents import Channel
from frictionloop.recordings.lifted_finger import off_plate
from frictionloop.recordings.read import scaled
from frictionloop.recordings.signs import Signs, signs_of


class Found(NamedTuple):
    """What was read of a recording."""

    column: str
    unit: str
    """Unit of the column."""
    unit_by: str
    """"file", "given" or "full scale"; "taken for N" where nothing tells it, and "scale" where that stands for it."""
    rate_hz: float
    rate_by: str
    """What tells the rate: the column of times, an attribute, the format, or the flag."""
    samples: int
    lowest_n: float
    highest_n: float
    """Range of the signal, in N."""
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
    off_plate: str
    """Stretches of it in s where the finger seems off the plate, "" without any (`contact.off_plate`)."""
    on_plate_s: tuple[float, float] | None
    """The longest part without such."""
    from_s: float
    to_s: float
    """First and last time of the part in use, as ``start_s`` counts."""
    findings: tuple[Finding, ...]
    """What was found of the file, and of its times."""

    @property
    def largest_n(self) -> float:
        """Largest magnitude in the file in N."""
        return max(abs(self.raw_lowest_n), abs(self.raw_highest_n))


def found(recording: Recording) -> Found:
    """Return what was read of a recording."""
    force, file_hz, channel, part, findings = scaled(recording, "N")
    raw = scaled(recording.model_copy(update={"remove_mean": False, "offset_n": 0.0}), "N").force
    unit, by = _unit(recording, channel)
    mean_n = float(force.mean())
    zeroed = raw if recording.remove_mean else force  # an offset is that of the sensor, or a level beside a mean
    off, on_s = off_plate(zeroed, file_hz, part.at_s) or ("", None)
    return Found(
        column=channel.name,
        unit=unit,
        unit_by=by,
        rate_hz=file_hz,
        rate_by=part.by,
        samples=force.size,
        lowest_n=float(force.min()),
        highest_n=float(force.max()),
        raw_lowest_n=float(raw.min()),
        raw_highest_n=float(raw.max()),
        raw_mean_n=float(raw.mean()),
        signs=signs_of(zeroed, raw.size / file_hz),
        # Of a mean that is removed its rounding is left.
        mean_n=0.0 if abs(mean_n) <= 1e-9 * float(np.abs(raw).max()) else mean_n,
        rms_n=float(force.std()),
        off_plate=off,
        on_plate_s=on_s,
        from_s=float(part.at_s[0]),
        to_s=float(part.at_s[-1]),
        findings=findings,
    )


def _unit(recording: Recording, channel: Channel) -> tuple[str, str]:
    """Return the unit of a column, and what says it."""
    if recording.unit is not None:
        return known_unit(recording.unit) or recording.unit, "given"
    if channel.full_scale and recording.scale is None:
        return "full scale", "full scale"
    if channel.unit:
        return channel.unit, "file"
    return ("N", "taken for N") if recording.scale is None else ("", "scale")
