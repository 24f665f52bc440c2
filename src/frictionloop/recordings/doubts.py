"""Signals from a file or an array that are probably read wrongly: what was seen, and what was probably meant."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from frictionloop.findings import Condition, Finding
from frictionloop.parameters import Recording, Samples, System
from frictionloop.recordings.signs import signs_of
from frictionloop.recordings.told import Found, found

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
