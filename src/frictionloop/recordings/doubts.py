"""Signals from a file or an array that are probably read wrongly: what was seen, and what was probably meant."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

import numpy as np

from frictionloop.parameters import Recording, Samples, System
from frictionloop.recordings.signs import signs_of
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


class Remedy(NamedTuple):
    """A value of a recording's parameter that may be meant, None for any other, and what does the same to an array."""

    parameter: str
    value: str | float | bool | None
    of_array: str = ""


class Doubt(NamedTuple):
    """A question about a signal; ``{}`` in what is said stands for the remedy."""

    about: Literal["size", "signs", "name", "mean", "contact", "small"]
    signal: str
    said: str
    meant: Remedy
    is_array: bool = False
    also: tuple[Remedy, ...] = ()
    """What belongs to the remedy."""

    def in_flags(self) -> str:
        """Return the question with the remedy as flags of the command line."""
        return self._asked(" ".join(self._flag(each) for each in (self.meant, *self.also)))

    def _flag(self, remedy: Remedy) -> str:
        value = "true" if remedy.value is True else "" if remedy.value is None else remedy.value
        value = f"{value:.9g}" if isinstance(value, float) else value
        return f"--{self.signal}.{remedy.parameter} {value}".rstrip()

    def in_python(self) -> str:
        """Return the question with the remedy as Python has it."""
        if self.meant.value is None:
            return self._asked(f'"{self.signal}.{self.meant.parameter}"')
        known = (f'"{self.signal}.{each.parameter}": {each.value!r}' for each in (self.meant, *self.also))
        return self._asked(f"evolve({{{', '.join(known)}}})")

    def _asked(self, remedy: str) -> str:
        return self.said.format(self.meant.of_array if self.is_array else remedy)


RECTIFY = Remedy("rectify", True, "abs(values)")


def doubts_of(system: System, signals: Sequence[str] = SIGNALS) -> Iterator[Doubt]:
    """Yield the questions about the signals of a system; none about those of a formula.

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


def _of_recording(name: str, signal: Recording, each: Found) -> Iterator[Doubt]:
    before = " before its mean is removed" if signal.remove_mean else ""
    other = "the load on the finger" if LOAD.search(each.column) else ""
    if COEFFICIENT.search(each.column) and each.unit_by == "taken for N":
        other = "a coefficient of friction, to be multiplied by the load"
    if other:
        said = f"The recorded {name} is column {each.column!r}: is that {other}? {name} is a friction force; "
        yield Doubt("name", name, said + "{} takes another column.", Remedy("column", "NAME"))
    elif name == "disturbance" and each.samples > 1 and each.rms_n <= ROUNDING * each.largest_n:
        said = f"The recorded disturbance, column {each.column!r}, is always the same; "
        yield Doubt("name", name, said + "{} takes another column.", Remedy("column", "NAME"))
    if OUTPUT.search(each.column) and each.unit_by == "taken for N":
        said = (
            f"The recorded {name} is column {each.column!r}: is that what a sensor puts out, in volts or counts? It is "
        )
        yield Doubt(
            "size",
            name,
            said + "taken for newtons; {} with the newtons of one of them scales it.",
            Remedy("scale", None),
        )
    if each.largest_n > FINGERS_N:
        meant = Remedy("unit", "mN") if each.unit == "N" else Remedy("scale", None)
        yield _too_large(name, each.largest_n, before, meant)
    if signal.rectify is None:
        range_n = f"{each.raw_lowest_n:.3g} to {each.raw_highest_n:.3g} N"
        yield from _signed(name, each.signs, range_n + before, RIGHT + LIFTED * (not signal.remove_mean))
    if name == "disturbance":
        yield from _too_small(each.rms_n, each.largest_n, _larger(each))
    if name == "disturbance" and each.on_plate_s is not None:
        yield _off_plate(each.off_plate, each.on_plate_s)


def _of_array(name: str, signal: Samples) -> Iterator[Doubt]:
    values = np.array(signal.values_n)
    largest_n = float(np.abs(values).max())
    asked = [_too_large(name, largest_n, "", Remedy("", None, "values / 1000"))] if largest_n > FINGERS_N else []
    range_n = f"{values.min():.3g} to {values.max():.3g} N"
    asked += _signed(name, signs_of(values, signal.longest_s), range_n, OFFSET)
    # A small array is how a loop's response is measured; a recording of a finger is not small.
    yield from (each._replace(is_array=True) for each in asked)


def _too_large(name: str, largest_n: float, before: str, meant: Remedy) -> Doubt:
    another = "another " if meant.parameter == "scale" else ""
    said = f"The recorded {name} is up to {largest_n:.4g} N{before}; did you mean {another}{{}}?"
    return Doubt("size", name, said, meant)


def _too_small(rms_n: float, largest_n: float, meant: Remedy) -> Iterator[Doubt]:
    """Yield a question about a disturbance that hardly varies, though it does."""
    if ROUNDING * largest_n < rms_n < LEAST_N:
        another = "" if meant.value is not None else "another "
        said = f"The recorded disturbance varies by {1e3 * rms_n:.3g} mN rms only; did you mean {another}{{}}?"
        yield Doubt("small", "disturbance", said, meant)


def _larger(each: Found) -> Remedy:
    """Return what makes a signal larger."""
    if each.unit in ("mN", "uN"):
        return Remedy("unit", "N") if each.unit_by == "given" else Remedy("scale", 1.0)
    return Remedy("unit" if each.unit_by == "taken for N" else "scale", None)


RIGHT = "with rectify = false the signs are right as they are, as where the zero of the sensor is off"
LIFTED = "; offset_n is added to all values"
OFFSET = "If it is the sensor that is off, offset_n is added to all values"


def _signed(name: str, signs: str, range_n: str, otherwise: str) -> Iterator[Doubt]:
    """Yield the question about the signs of a signal; ``otherwise`` is what to do where they are right."""
    seen = {
        "both": f"has both signs, {range_n}, as friction of strokes both ways; did you mean its magnitude, {{}}?",
        "below": f"is below 0, {range_n}, and friction is above; did you mean its magnitude, {{}}, or the other sign?",
    }.get(signs)
    if seen:
        yield Doubt("signs", name, f"The recorded {name} {seen} {otherwise[0].upper()}{otherwise[1:]}.", RECTIFY)


def _off_plate(where: str, on_plate_s: tuple[float, float]) -> Doubt:
    start, stop = (Remedy(name, round(at_s, 9)) for name, at_s in zip(("start_s", "stop_s"), on_plate_s, strict=True))
    said = f"The recorded disturbance is near 0 at {where}: is the finger off the plate there? The longest part on the "
    lasts_s = on_plate_s[1] - on_plate_s[0]
    return Doubt("contact", "disturbance", f"{said}plate lasts {lasts_s:.3g} s: {{}}.", start, also=(stop,))
