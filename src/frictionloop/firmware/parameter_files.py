"""Parameters of the firmware in their units, all doubles, and a table of them as files."""

from __future__ import annotations

import csv
import io
import zlib
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from frictionloop.parameters import System, write_toml
from frictionloop.quantities import FrictionloopError, must_be, replacing
from frictionloop.quantities.protocol_schema import Word, parameter_words, word_count


def word_of(name: str) -> Word:
    """Return a parameter by name, or name the near ones."""
    words = parameter_words()
    if name not in words:
        near = get_close_matches(str(name), words, 3, 0.4)
        blocks = dict.fromkeys(f"{known.partition('.')[0]}.*" for known in words)
        others = f"near: {', '.join(near)}" if near else f"there are {', '.join(blocks)} (docs/protocol.md)"
        raise FrictionloopError(f"parameter {name!r}: unknown; {others}", "UNKNOWN-NAME")
    return words[name]


def word_at(index: int) -> Word:
    """Return the parameter that has a word of the table."""
    return next(word for word in parameter_words().values() if word.first <= index < word.first + word.count)


def to_words(word: Word, value: Any) -> np.ndarray:
    """Return the words of a parameter's value: a number, or `count` of them."""
    try:
        numbers = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        raise must_be(word.name, value, accepted(word)) from None
    if numbers.shape != (word.count,):
        raise must_be(word.name, numbers.size, str(word.count), "numbers")
    for number in numbers:
        _check(word, float(number))
    return numbers


def filled(words: dict[str, np.ndarray]) -> np.ndarray:
    """Return the parameter table with these words by name, 0 elsewhere."""
    table = np.zeros(word_count())
    for name, values in words.items():
        word = word_of(name)
        table[word.first : word.first + word.count] = values
    return table


def from_words(word: Word, words: np.ndarray) -> float | np.ndarray:
    """Return the value of a parameter's words in its unit; an array where it has several numbers."""
    numbers = np.asarray(words, dtype=float)
    return float(numbers[0]) if word.count == 1 else numbers


def shown(word: Word, value: float | np.ndarray) -> str:
    """Return a parameter's value as text with its unit; of several numbers how many there are."""
    digits = 10 if word.format == "count" else 6
    number = f"{value:.{digits}g}" if isinstance(value, float) else f"{len(value)} numbers"
    return f"{number} {word.unit}".rstrip()


def accepted(word: Word) -> str:
    """Return in words what a parameter takes."""
    unit = f" {word.unit}" if word.unit else ""
    kind = "a whole number" if word.format == "count" else "a number"
    return f"{kind} from {word.low:.10g} to {word.high:.10g}{unit}"


def _check(word: Word, number: float) -> None:
    if not word.low <= number <= word.high or (word.format == "count" and number != round(number)):
        raise must_be(word.name, number, accepted(word), word.unit)


class Number(NamedTuple):
    """A number of a parameter table; the fields are the columns of parameters.csv."""

    word: int
    """Its index."""
    name: str
    """The parameter's, with the place in brackets where it has several numbers."""
    value: float
    unit: str
    meaning: str


def fingerprint(words: np.ndarray) -> str:
    """Return the CRC-32 of all words of a table, little-endian, in hexadecimal: that of parameters.bin as a file."""
    return f"{zlib.crc32(words.astype('<f8').tobytes()):08x}"


def numbers(words: np.ndarray) -> Iterator[Number]:
    """Yield every number of a parameter table."""
    for word in parameter_words().values():
        for k in range(word.count):
            name = f"{word.name}[{k}]" if word.count > 1 else word.name
            yield Number(word.first + k, name, float(words[word.first + k]), word.unit, word.text)


def differing(words: np.ndarray, others: np.ndarray) -> list[tuple[str, str, str]]:
    """Return the name of each number that differs between two tables, with its value in either."""
    pairs = zip(numbers(words), numbers(others), strict=True)
    return [(one.name, *_apart(one, other)) for one, other in pairs if one.value != other.value]


def _apart(one: Number, other: Number) -> tuple[str, str]:
    """Return two values with as many digits as tell them apart."""
    for digits in (6, 12, 17):
        texts = f"{one.value:.{digits}g}", f"{other.value:.{digits}g}"
        if texts[0] != texts[1]:
            break
    return f"{texts[0]} {one.unit}".rstrip(), f"{texts[1]} {other.unit}".rstrip()


FINGERPRINT = "values.txt"
"""File with the fingerprint of the values, as `device info` prints it."""


def write_table(system: System, words: np.ndarray, folder: Path) -> None:
    """Write parameters.bin (little-endian doubles), parameters.csv, values.txt and system.toml into a folder."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(Number._fields)
    writer.writerows(numbers(words))
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise must_be("out", str(folder), f"a folder ({error.strerror})") from None
    with replacing(folder / "parameters.bin") as fresh:
        fresh.write_bytes(words.astype("<f8").tobytes())
    with replacing(folder / "parameters.csv") as fresh:
        fresh.write_text(text.getvalue(), encoding="utf-8")
    with replacing(folder / FINGERPRINT) as fresh:
        fresh.write_text(f"values {fingerprint(words)}\n", encoding="ascii")
    write_toml(system, folder / "system.toml")
