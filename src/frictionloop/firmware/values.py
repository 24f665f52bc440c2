"""The values of a parameter table: each number with its unit, their fingerprint, and where two tables differ."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from frictionloop.firmware.words import from_words
from frictionloop.quantities.schema import parameter_words


class Number(NamedTuple):
    """A number of a parameter table; the fields are the columns of parameters.csv."""

    word: int
    """Index of its first word."""
    name: str
    """The parameter's, with the place in brackets where it has several numbers."""
    value: float
    unit: str
    raw: str
    """Its words as whole numbers."""
    meaning: str


def fingerprint(words: np.ndarray) -> str:
    """Return the CRC-32 of all words of a table, little-endian, in hexadecimal: that of parameters.bin as a file."""
    return f"{zlib.crc32(words.astype('<i4').tobytes()):08x}"


def numbers(words: np.ndarray) -> Iterator[Number]:
    """Yield every number of a parameter table."""
    for word in parameter_words().values():
        each = word.words // word.count
        value = np.atleast_1d(from_words(word, words[word.first : word.first + word.words]))
        for k in range(word.count):
            first = word.first + k * each
            name = f"{word.name}[{k}]" if word.count > 1 else word.name
            raw = " ".join(map(str, words[first : first + each].tolist()))
            yield Number(first, name, float(value[k]), word.unit, raw, word.text)


def differing(words: np.ndarray, others: np.ndarray) -> list[tuple[str, str, str]]:
    """Return the name of each number that differs between two tables, with its value in either."""
    pairs = zip(numbers(words), numbers(others), strict=True)
    return [(one.name, *_apart(one, other)) for one, other in pairs if one.raw != other.raw]


def _apart(one: Number, other: Number) -> tuple[str, str]:
    """Return two values with as many digits as tell them apart; their words where no digits do."""
    for digits in (6, 12):
        texts = f"{one.value:.{digits}g}", f"{other.value:.{digits}g}"
        if texts[0] != texts[1]:
            return f"{texts[0]} {one.unit}".rstrip(), f"{texts[1]} {other.unit}".rstrip()
    return f"words {one.raw}", f"words {other.raw}"
