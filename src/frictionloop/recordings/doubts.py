"""Signals from a file or an array that are probably read wrongly: what was seen, and what was probably meant."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from frictionloop.findings import Condition, Finding
from frictionloop.parameters import Recording, Samples, System
from frictionloop.recordings.signs import Signs, signs_of
from frictionloop.recordings.told import Found, found

SIGNALS = ("setpoint", "disturbance")
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
About = Literal["size", "signs", "name", "mean", "contact", "small"]
Remedy = dict[str, str | float | bool]
"""Parameters of a recording and what they should be; "" is whatever is right."""


class Doubt(NamedTuple):
    """A finding about a signal, with its remedy as flags, and what does the same to an array."""

    about: About
    finding: Finding
    of_array: str = ""
    is_array: bool = False

    def in_flags(self) -> str:
        """Return the line with the remedy as flags of the command line."""
        meant = self.finding.remedy
        if self.is_array or not isinstance(meant, dict):
            return str(replace(self.finding, remedy=self.of_array))
        return str(replace(self.finding, remedy=" ".join(f"--{name} {_flag(each)}" for name, each in meant.items())))

    def in_python(self) -> str:
        """Return the line with the remedy as Python has it."""
        meant = self.finding.remedy
        if self.is_array or not isinstance(meant, dict):
            return self.in_flags()
        if "" in meant.values():
            return str(replace(self.finding, remedy=", ".join(f'"{name}"' for name in meant)))
        known = ", ".join(f'"{name}": {value!r}' for name, value in meant.items())
        return str(replace(self.finding, remedy=f"evolve({{{known}}})"))


def _flag(value: str | float | bool) -> str:
    """Return a value as a flag has it, a time with all its digits."""
    return str(value).lower() if isinstance(value, bool) else f"{value:.9g}" if isinstance(value, float) else value


def doubt(code: str, about: About, signal: str, remedy: Remedy, column: str = "", **numbers: object) -> Doubt:
    """Return a doubt about a signal; ``numbers`` are those of the finding, or stand in its line by name."""
    own = {name: numbers.pop(name) for name in ("value", "unit", "limit") if name in numbers}
    flags = {f"{signal}.{name}": value for name, value in remedy.items()}
    where = Condition(recording=signal, channel=column)
    return Doubt(about, Finding(code, where=where, remedy=flags, more=numbers, **own))  # type: ignore[arg-type]


def doubts_of(system: System, signals: Sequence[str] = SIGNALS) -> Iterator[Doubt]:
    """Yield the questions about the signals of a system; none about those of a formula."""
    for name in signals:
        signal = getattr(system, name)
        if isinstance(signal, Recording):
            yield from _of_recording(name, signal, found(signal))
        elif isinstance(signal, Samples):
            yield from _of_array(name, signal)


def _of_recording(name: str, signal: Recording, each: Found) -> Iterator[Doubt]:
    meant = "a load" if LOAD.search(each.column) else ""
    if COEFFICIENT.search(each.column) and each.unit_by == "taken for N":
        meant = "a coefficient"
    if name == "disturbance" and each.samples > 1 and each.rms_n <= ROUNDING * each.largest_n:
        meant = meant or "always the same"
    if meant:
        yield doubt("COLUMN-DOUBT", "name", name, {"column": ""}, each.column, meant=meant)
    if OUTPUT.search(each.column) and each.unit_by == "taken for N":
        yield doubt("COLUMN-DOUBT", "size", name, {"scale": ""}, each.column, meant="volts or counts")
    if each.largest_n > FINGERS_N:
        other: Remedy = {"unit": "mN"} if each.unit == "N" else {"scale": ""}
        yield _unit(name, "size", each.largest_n, 0.0, FINGERS_N, other)
    if signal.rectify is None:
        yield from _signed(name, each.signs, each.raw_lowest_n, each.raw_highest_n, each.column)
    if name == "disturbance" and ROUNDING * each.largest_n < each.rms_n < LEAST_N:
        yield _unit(name, "small", each.rms_n, LEAST_N, FINGERS_N, _larger(each))
    if name == "disturbance" and each.on_plate_s is not None:
        ends: Remedy = {key: round(at, 9) for key, at in zip(("start_s", "stop_s"), each.on_plate_s, strict=True)}
        lasts_s = each.on_plate_s[1] - each.on_plate_s[0]
        yield doubt("FINGER-OFF", "contact", name, ends, each.column, value=lasts_s, unit="s", times=each.off_plate)


def _of_array(name: str, signal: Samples) -> Iterator[Doubt]:
    values = np.array(signal.values_n)
    largest_n = float(np.abs(values).max())
    if largest_n > FINGERS_N:
        yield _unit(name, "size", largest_n, 0.0, FINGERS_N, {})._replace(of_array="values / 1000", is_array=True)
    # A small array is how a loop's response is measured; a recording of a finger is not small.
    for each in _signed(name, signs_of(values, signal.longest_s), float(values.min()), float(values.max())):
        yield each._replace(of_array="abs(values)", is_array=True)


def _unit(name: str, about: About, size_n: float, low_n: float, high_n: float, meant: Remedy) -> Doubt:
    path = f"{name} rms" if about == "small" else name
    return doubt("UNIT-DOUBT", about, name, meant, value=size_n, unit="N", path=path, low=low_n, high=high_n)


def _larger(each: Found) -> Remedy:
    """Return what makes a signal larger."""
    if each.unit in ("mN", "uN"):
        return {"unit": "N"} if each.unit_by == "given" else {"scale": 1.0}
    return {"unit" if each.unit_by == "taken for N" else "scale": ""}


def _signed(name: str, signs: Signs, low_n: float, high_n: float, column: str = "") -> Iterator[Doubt]:
    """Yield the question about the signs of a signal."""
    if signs:
        yield doubt("SIGN-DOUBT", "signs", name, {"rectify": True}, column, unit="N", low=low_n, high=high_n)
