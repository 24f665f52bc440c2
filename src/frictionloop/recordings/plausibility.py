"""What was read of a recorded signal, what of it is probably read wrongly, and what was probably meant."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from frictionloop.findings import Condition, Finding
from frictionloop.parameters import Recording, Samples, System
from frictionloop.quantities.units import known_unit
from frictionloop.recordings.contents import Channel
from frictionloop.recordings.force_shape import Signs, off_plate, signs_of
from frictionloop.recordings.read import scaled


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


FINGERS_N = 10.0
"""Force above which a unit is asked about: no finger slides under so much (assumed)."""
LEAST_N = 1e-3
"""Variation (rms) of a disturbance below which its unit is asked about: that of fingers is some 10 mN (assumed)."""
ROUNDING = 1e-9
"""Variation that is none, as a share of the largest magnitude."""
LOAD = re.compile(
    r"(?<![a-z])(normale?|load|preload|weight|fz|fn|grip|(normal|andruck|andrück|anpress|anpreß|auflage)kraft|auflast|"
    r"appui)(?![a-z])",
    re.IGNORECASE,
)
"""Names of what presses on the finger in English, German and French; in a recording it stands beside the friction."""

COEFFICIENT = re.compile(
    r"(?<![a-z])(mu|[µμ]|cof|friction[ _-]*coeff?(icient)?|coeff?(icient)?[ _-]*of[ _-]*friction)(?![a-z])",
    re.IGNORECASE,
)
"""Names of friction over load, which is no force."""

OUTPUT = re.compile(r"(?<![a-z])(volts?|voltage|spannung|tension électrique|counts?|adc|raw)(?![a-z])", re.IGNORECASE)
"""Names of what a sensor puts out, which a scale makes a force."""
OF_FILE = ("DATA-GAPS", "LEFT-OUT", "NAMES-FEWER", "TIMES-UNEVEN")
"""Findings of a file that may make a signal another."""
ARRAY = {"rectify": "abs(values)", "unit": "values / 1000", "remove_mean": "values - values.mean()"}
"""What does to an array what a parameter does to a recording."""


def doubts_of(system: System, signals: Sequence[str] = ("setpoint", "disturbance")) -> Iterator[Finding]:
    """Yield what is in doubt of the signals of a system; nothing of those of a formula.

    Raises
    ------
    FrictionloopError
        As `read_recording`.
    """
    for name in signals:
        signal = getattr(system, name)
        if isinstance(signal, Recording):
            yield from _of_recording(name, signal, found(signal))
        elif isinstance(signal, Samples):
            yield from _of_array(name, signal)


def doubt(
    code: str, name: str, value: Any, remedy: Mapping[str, Any] | str, array: bool = False, **more: Any
) -> Finding:
    """Return a doubt about a signal; a remedy names parameters of a recording, or those whose other value is meant."""
    if array:
        meant: Mapping[str, Any] | str = ARRAY[next(iter(remedy))]
    elif isinstance(remedy, str):
        meant = f"another {name}.{remedy}"
    else:
        meant = {f"{name}.{key}": each for key, each in remedy.items()}
    unit = more.pop("unit", "")
    return Finding(code, value=value, unit=unit, where=Condition(recording=name), remedy=meant, more=more)


def _of_recording(name: str, signal: Recording, each: Found) -> Iterator[Finding]:
    yield from (replace(one, where=replace(one.where, recording=name)) for one in each.findings if one.code in OF_FILE)
    taken = each.unit_by == "taken for N"
    steady = name == "disturbance" and each.samples > 1 and each.rms_n <= ROUNDING * each.largest_n
    if OUTPUT.search(each.column) and taken:
        yield doubt("COLUMN-DOUBT", name, each.column, "scale", meant="volts or counts")
    elif LOAD.search(each.column):
        yield doubt("COLUMN-DOUBT", name, each.column, "column", meant="a load")
    elif COEFFICIENT.search(each.column) and taken:
        yield doubt("COLUMN-DOUBT", name, each.column, "column", meant="a coefficient")
    elif steady:
        yield doubt("COLUMN-DOUBT", name, each.column, "column", meant="always the same")
    if each.largest_n > FINGERS_N:
        meant: Any = {"unit": "mN"} if each.unit == "N" else "scale"
        yield doubt("UNIT-DOUBT", name, each.largest_n, meant, **_usual(name))
    if signal.rectify is None:
        yield from _signed(name, each.signs, (each.raw_lowest_n, each.raw_highest_n))
    if name == "disturbance" and ROUNDING * each.largest_n < each.rms_n < LEAST_N:
        yield doubt("UNIT-DOUBT", name, each.rms_n, _larger(each), **_usual("rms of disturbance", LEAST_N))
    if name == "disturbance" and each.on_plate_s is not None:
        start, stop = (round(at_s, 9) for at_s in each.on_plate_s)
        cut = {"start_s": start, "stop_s": stop}
        yield doubt("FINGER-OFF", name, stop - start, cut, unit="s", times=each.off_plate)


def _of_array(name: str, signal: Samples) -> Iterator[Finding]:
    values = np.array(signal.values_n)
    largest_n = float(np.abs(values).max())
    if largest_n > FINGERS_N:
        yield doubt("UNIT-DOUBT", name, largest_n, {"unit": "mN"}, array=True, **_usual(name))
    # A small array is how a loop's response is measured; a recording of a finger is not small.
    yield from _signed(name, signs_of(values, signal.longest_s), (values.min(), values.max()), array=True)


def _usual(path: str, least_n: float = 0.0) -> dict[str, Any]:
    return {"unit": "N", "path": path, "low": least_n, "high": FINGERS_N}


def _larger(each: Found) -> Mapping[str, Any] | str:
    """Return what makes a signal larger."""
    if each.unit in ("mN", "uN"):
        return {"unit": "N"} if each.unit_by == "given" else {"scale": 1.0}
    return "unit" if each.unit_by == "taken for N" else "scale"


def _signed(name: str, signs: str, ends_n: tuple[float, float], array: bool = False) -> Iterator[Finding]:
    """Yield that a signal has both signs, or is below 0, as friction with the sign of the motion."""
    if signs in ("both", "below"):
        low_n, high_n = map(float, ends_n)
        yield doubt("SIGN-DOUBT", name, signs, {"rectify": True}, array=array, unit="N", low=low_n, high=high_n)
