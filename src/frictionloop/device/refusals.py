"""A refused parameter table, said with the names of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from frictionloop.device.errors import Refused
from frictionloop.firmware.built_in import KINDS
from frictionloop.firmware.words import accepted, from_words, shown, word_at
from frictionloop.quantities.schema import Word, parameter_words, schema

PROTOCOL = schema()["protocol"]
LONGEST_RAMP = PROTOCOL["ramp_ms"] * PROTOCOL["tick_hz"] / 1000
"""Ticks from the ceiling to 0 at most."""
RELATIONS: dict[str, Callable[[dict[str, Any]], str]] = {
    "law.high_n": lambda value: f"above law.low_n = {value['law.low_n']:g} N",
    "drive.largest_um": lambda value: "above 0 um",
    "drive.ceiling_um": lambda value: (
        f"at most drive.largest_um = {value['drive.largest_um']:g} um, at the image's share"
    ),
    "drive.ramp_um": lambda value: (
        f"at least {value['drive.ceiling_um'] / LONGEST_RAMP:.4g} um, ramp {PROTOCOL['ramp_ms']} ms"
    ),
    "lookup.squares_um2": lambda value: "none above the one before",
}
"""What the firmware asks of a parameter beside its range (firmware/core/app_parameters.c, fl_check_table)."""


def in_words(asked: str, refused: Refused, table: np.ndarray, laws: Sequence[str]) -> Refused:
    """Return a refusal of `set` or `commit` that names the parameter, its value and what would be accepted.

    `laws` are those that the device has.

    A refusal that has no ``index``, that of the word that is wrong in the table, is returned as it is.
    """
    if refused.index is None or refused.index >= len(table) or refused.reason != "out_of_range":
        return refused
    word = word_at(refused.index)
    values = np.atleast_1d(from_words(word, table[word.first : word.first + word.words]))
    entry = (refused.index - word.first) * word.count // word.words
    number, name = float(values[entry]), f"{word.name}[{entry}]" if word.count > 1 else word.name
    said = f"{asked}: refused, {name} = {shown(word, number)}"
    must = _law(number, laws) if word.name == "law.number" else _limit(word, number, table)
    return Refused(f"{said}: must be {must}", refused.reason, refused.index)


def _law(number: float, laws: Sequence[str]) -> str:
    """Return which laws the device has, and how it gets another that the firmware has."""
    has = ", ".join(f"{1 + KINDS.index(kind)} {kind}" for kind in laws)
    other = KINDS[int(number) - 1] if 0 < number <= len(KINDS) else None
    return f"one of {has}" + (f"; firmware build --laws {other}" if other else "")


def _limit(word: Word, number: float, table: np.ndarray) -> str:
    """Return what is accepted: the range where that is broken, else how it goes with the others."""
    inside = (word.low is None or word.low <= number) and (word.high is None or number <= word.high)
    if not inside or word.name not in RELATIONS:
        return accepted(word)
    words = parameter_words().values()
    values = {other.name: from_words(other, table[other.first : other.first + other.words]) for other in words}
    return RELATIONS[word.name](values)
