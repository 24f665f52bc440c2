"""A measured force: one channel of a file, cut, scaled and brought to the rate of the loop."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from frictionloop.findings import Finding
from frictionloop.parameters.input_signals import Recording
from frictionloop.quantities import Array, FrictionloopError, must_be
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings.channel_excerpt import EVEN, Part, part_of
from frictionloop.recordings.contents import Channel, Contents, find_channel, refuse_column
from frictionloop.recordings.file_opening import read_contents
from frictionloop.recordings.friction_defects import clean_part, refuse_gaps
from frictionloop.recordings.sampling import resampled

ROUNDING = 1e-9
"""Mean that is none, as a share of the largest magnitude."""
DEFAULT = "(the default of --disturbance.column and --setpoint.column)"


def read_recording(recording: Recording, rate_hz: float) -> Array:
    """Return the recorded force in newtons at t_k = k / rate_hz, from ``start_s`` to ``stop_s`` or the end.

        force = offset_n + f,  f = scale * column, |scale * column| with ``rectify``, less its mean if that is removed,

    the mean over the samples used, of the magnitude if that is taken. Both ends are included: a window of D seconds
    gives D * rate_hz + 1 values (one less at the end of the file). At the file's own rate the samples are copied
    exactly. At another they are resampled band-limited (`scipy.signal.resample_poly`; zero phase, flat to 0.8 of the
    lower of the two Nyquist frequencies, -100 dB above it) at a rational ratio right to 10 ppm; the straight line from
    the first to the last sample is set aside and put back, the rest mirrored at both ends, so that they do not ring.

    Parameters
    ----------
    recording
        File (`read_contents`), channel (`find_channel`) and part. The rate is that of the channel: its format's, of the
        times, attribute or number nearest to it, or ``rate_hz``; uneven times are brought to ``resample_hz``. A column
        whose header or attribute says a unit of force (mN) is scaled, one that says another needs ``scale``.
    rate_hz
        Rate of the result in Hz, positive, at most 1e5 times above or below that of the file.

    Returns
    -------
    Force in N, shape (samples,).

    Raises
    ------
    FrictionloopError
        In one line: what `read_contents` and `find_channel` raise; a channel of times, of an unknown unit, without a
        rate or against one, uneven or without a number in the part in use (with its line); a part past the end.
    """
    taken = scaled(recording)
    return resampled(taken.force, taken.rate_hz, rate_hz, recording.path)


def read_held(recording: Recording, rate_hz: float) -> Array:
    """Return the same in newtons with the last sample held for one of its own periods, as a signal of the loop.

    So 20 000 samples at 1 kHz last 20 s. A window that ``stop_s`` ends lasts no longer than it says.
    """
    taken = scaled(recording)
    found = resampled(taken.force, taken.rate_hz, rate_hz, recording.path)
    held = math.floor(_lasts_s(recording, taken) * rate_hz + 1e-6) + 1 - found.size
    return np.pad(found, (0, max(held, 0)), mode="edge")


def lasting_s(recording: Recording) -> float:
    """Return how long the part in use lasts in s, its last sample held."""
    return _lasts_s(recording, scaled(recording))


def _lasts_s(recording: Recording, taken: Taken) -> float:
    begins_s, start_s = float(taken.part.at_s[0]), recording.start_s
    given = start_s is not None and start_s > begins_s - 1 / taken.rate_hz
    cut_s = math.inf if recording.stop_s is None else recording.stop_s - (start_s if given and start_s else begins_s)
    return min(taken.force.size / taken.rate_hz, cut_s)


class Taken(NamedTuple):
    """The part of a recording in use."""

    force: Array
    """In N."""
    raw: Array
    """Before a mean is removed and an offset added."""
    rate_hz: float
    channel: Channel
    part: Part
    unit: str
    """Unit of the column."""
    unit_by: str
    """"file", "given" or "full scale"; "taken for N" where nothing tells it, and "scale" where that stands for it."""
    findings: tuple[Finding, ...]
    """What was found of the file, and of its times."""

    def summary(self) -> dict[str, Any]:
        """Return what was read in figures: the signal's in N, those of the file (``raw``), and times as ``start_s``."""
        force, raw, at_s = self.force, self.raw, self.part.at_s
        return {
            "column": self.channel.name,
            **{"unit": self.unit, "unit_by": self.unit_by, "rate_hz": self.rate_hz, "rate_by": self.part.by},
            **{"samples": force.size, "from_s": float(at_s[0]), "to_s": float(at_s[-1])},
            **{"lowest_n": float(force.min()), "highest_n": float(force.max()), "rms_n": float(force.std())},
            **{"raw_lowest_n": float(raw.min()), "raw_highest_n": float(raw.max()), "raw_mean_n": float(raw.mean())},
            "mean_n": mean_of(force),
        }


def mean_of(force: Array) -> float:
    """Return a mean, 0 where it is the rounding of one that was removed."""
    mean = float(np.mean(force))
    return 0.0 if abs(mean) <= ROUNDING * float(np.abs(force).max()) else mean


def scaled(recording: Recording) -> Taken:
    """Return the part in use in newtons."""
    contents = read_contents(recording.path, recording.decimal)
    channel = _picked(recording, contents)
    used, part = _used(recording, channel)
    scale = recording.scale
    if scale is None and recording.unit is None and channel.unit_in_doubt:
        raise FrictionloopError(f"{recording.path}: {channel.unit_in_doubt}")
    origin = recording.offset_n
    if scale is None and recording.unit is None and channel.newtons is not None:
        scale, origin = channel.newtons[0], origin + channel.newtons[1]
    if scale is None:
        scale = scale_of(f"{recording.path}: column {channel.name!r}", recording.unit, channel.unit)
    if recording.rectify:
        used, scale = np.abs(used), abs(scale)
    level = used.mean() if recording.remove_mean else 0.0
    force = origin + scale * (used - level)
    found = (*_of_file(recording, contents, channel), *part.findings)
    return Taken(force, scale * used, part.rate_hz, channel, part, *_unit(recording, channel), found)


def _of_file(recording: Recording, contents: Contents, channel: Channel) -> Iterator[Finding]:
    """Yield what was found of a file that counts for one of its channels, and that nobody chose it."""
    yield from contents.findings_of([channel])
    signals = [each for each in contents.signals() if each.number is not None]
    if recording.column == Recording.model_fields["column"].default and len(signals) > 1:
        yield Finding("TAKEN-FOR", value=channel.name, unit=f"of {len(signals)}", more={"path": "column"})


def _unit(recording: Recording, channel: Channel) -> tuple[str, str]:
    """Return the unit of a column, and what says it."""
    if recording.unit is not None:
        return known_unit(recording.unit) or recording.unit, "given"
    if channel.newtons is not None and recording.scale is None:
        return "N", "file"
    if channel.full_scale and recording.scale is None:
        return "full scale", "full scale"
    if channel.unit:
        return channel.unit, "file"
    return ("N", "taken for N") if recording.scale is None else ("", "scale")


def _picked(recording: Recording, contents: Contents) -> Channel:
    """Return the channel that is asked for: the only signal where none is named, and no times."""
    path, column = recording.path, recording.column
    signals = [each for each in contents.signals() if each.samples.dtype.kind in "iufb" and each.unit != "Hz"]
    default = column == Recording.model_fields["column"].default
    if default and all(each.number is None for each in signals):
        if len(signals) > 1:
            raise refuse_column(path, column, f"{DEFAULT} may be any of {len(signals)} signals", signals)
        return signals[0] if signals else find_channel(path, contents, column)
    channel = find_channel(path, contents, column)
    others = [each for each in signals if each is not channel]
    if channel.samples.dtype.kind == "c":
        raise refuse_column(path, column, "holds complex numbers", others)
    guessed = column.strip().isdecimal() and recording.unit is None and bool(others)
    guessed = guessed and channel.times is None and not channel.rates_hz  # who tells the rate needs no times
    if channel.tells_time or (guessed and _rises_evenly(channel)):
        raise refuse_column(path, column, f"{f'{DEFAULT} ' if default else ''}holds times", others)
    return channel


def _rises_evenly(channel: Channel) -> bool:
    """Return whether a channel rises as no measured force does."""
    steps = np.diff(np.asarray(channel.samples[:1000], dtype=float))
    return steps.size > 1 and bool(steps.min() > 0) and bool(np.ptp(steps) <= 2 * EVEN * steps.mean())


def _used(recording: Recording, channel: Channel) -> tuple[Array, Part]:
    """Return the samples in use, and which they are."""
    part = part_of(recording, channel)
    used = np.array(channel.samples[part.first : part.stop], dtype=np.float64)
    where = clean_part(used, part.at_s)
    refuse_gaps(recording.path, used, lambda i: channel.place(part.first + i), *where)
    if part.even_s is None:
        return used, part
    return np.interp(part.even_s, part.at_s, used), part._replace(at_s=part.even_s)


def scale_of(where: str, given: str | None, found: str | None) -> float:
    """Return the factor from a column's unit to newtons, in which a column that says nothing is."""
    stated = found if given is None else known_unit(given)
    weighed = found in ("g", "kg") and stated == f"{found}f"  # which a scale writes as a mass
    if given is not None and found in UNITS and stated != found and not weighed:
        raise must_be(f"{where}: unit", given, f"{found!r}, as in the file")
    if given is None and found is None:
        return 1.0
    if stated not in UNITS or UNITS[stated][0] != "N":
        unit = given or found
        force = UNITS[f"{stated}f"][1] if stated in ("g", "kg") else 0.0
        known = f', such as {force:g}, or unit = "{stated}f"' if force else ""
        known += "" if given or found in UNITS else ', or unit = "N"'
        raise must_be(f"{where} in {unit}: scale", None, f"N per {unit}{known}")
    return UNITS[stated][1]
