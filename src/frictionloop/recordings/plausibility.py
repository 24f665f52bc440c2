"""Signals from a file or an array that are probably read wrongly: what was seen, and what was probably meant."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from frictionloop.findings import Condition, Finding
from frictionloop.parameters import Recording, Samples, System
from frictionloop.quantities import Array
from frictionloop.recordings.force_channel import Taken, scaled
from frictionloop.recordings.friction_defects import off_plate, signs_of

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
            yield from _of_recording(name, signal, scaled(signal))
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


def on_plate(signal: Recording, taken: Taken) -> tuple[str, tuple[float, float]] | None:
    """Return when a recorded finger seems off the plate, and the longest part without such (`off_plate`)."""
    return off_plate(_zeroed(signal, taken), taken.rate_hz, taken.part.at_s)


def _zeroed(signal: Recording, taken: Taken) -> Array:
    """Return a force with its own zero: an offset is that of the sensor, or a level beside a mean."""
    return taken.raw if signal.remove_mean else taken.force


def _of_recording(name: str, signal: Recording, taken: Taken) -> Iterator[Finding]:
    """Yield the doubts about a recorded signal."""
    yield from (replace(one, where=replace(one.where, recording=name)) for one in taken.findings if one.code in OF_FILE)
    largest_n, rms_n = float(np.abs(taken.raw).max()), float(taken.force.std())
    unnamed = taken.unit_by == "taken for N"
    steady = name == "disturbance" and taken.force.size > 1 and rms_n <= ROUNDING * largest_n
    column = taken.channel.name
    if OUTPUT.search(column) and unnamed:
        yield doubt("COLUMN-DOUBT", name, column, "scale", meant="volts or counts")
    elif LOAD.search(column):
        yield doubt("COLUMN-DOUBT", name, column, "column", meant="a load")
    elif COEFFICIENT.search(column) and unnamed:
        yield doubt("COLUMN-DOUBT", name, column, "column", meant="a coefficient")
    elif steady:
        yield doubt("COLUMN-DOUBT", name, column, "column", meant="always the same")
    if largest_n > FINGERS_N:
        meant: Any = {"unit": "mN"} if taken.unit == "N" else "scale"
        yield doubt("UNIT-DOUBT", name, largest_n, meant, **_usual(name))
    if signal.rectify is None:
        signs = signs_of(_zeroed(signal, taken), taken.raw.size / taken.rate_hz)
        yield from _signed(name, signs, (taken.raw.min(), taken.raw.max()))
    if name == "disturbance" and ROUNDING * largest_n < rms_n < LEAST_N:
        yield doubt("UNIT-DOUBT", name, rms_n, _larger(taken), **_usual("rms of disturbance", LEAST_N))
    if name == "disturbance" and (off := on_plate(signal, taken)) is not None:
        start, stop = (round(at_s, 9) for at_s in off[1])
        cut = {"start_s": start, "stop_s": stop}
        yield doubt("FINGER-OFF", name, stop - start, cut, unit="s", times=off[0])


def _of_array(name: str, signal: Samples) -> Iterator[Finding]:
    values = np.array(signal.values_n)
    largest_n = float(np.abs(values).max())
    if largest_n > FINGERS_N:
        yield doubt("UNIT-DOUBT", name, largest_n, {"unit": "mN"}, array=True, **_usual(name))
    # A small array is how a loop's response is measured; a recording of a finger is not small.
    yield from _signed(name, signs_of(values, signal.longest_s), (values.min(), values.max()), array=True)


def _usual(path: str, least_n: float = 0.0) -> dict[str, Any]:
    return {"unit": "N", "path": path, "low": least_n, "high": FINGERS_N}


def _larger(taken: Taken) -> Mapping[str, Any] | str:
    """Return what makes a signal larger."""
    if taken.unit in ("mN", "uN"):
        return {"unit": "N"} if taken.unit_by == "given" else {"scale": 1.0}
    return "unit" if taken.unit_by == "taken for N" else "scale"


def _signed(name: str, signs: str, ends_n: tuple[float, float], array: bool = False) -> Iterator[Finding]:
    """Yield that a signal has both signs, or is below 0, as friction with the sign of the motion."""
    if signs in ("both", "below"):
        low_n, high_n = map(float, ends_n)
        yield doubt("SIGN-DOUBT", name, signs, {"rectify": True}, array=array, unit="N", low=low_n, high=high_n)
