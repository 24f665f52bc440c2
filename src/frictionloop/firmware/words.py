"""Parameters of the firmware in their units, and the 32-bit words that stand for them."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any

import numpy as np

from frictionloop.firmware.quantised import to_gain
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.schema import BITS, Word, parameter_words, word_count


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
    return next(word for word in parameter_words().values() if word.first <= index < word.first + word.words)


def to_words(word: Word, value: Any) -> np.ndarray:
    """Return the words of a parameter's value: a number, or `count` of them.

    Raises
    ------
    FrictionloopError
        For a wrong count, or a number outside what the schema accepts.
    """
    try:
        numbers = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        raise must_be(word.name, value, accepted(word)) from None
    if numbers.shape != (word.count,):
        raise must_be(word.name, numbers.size, str(word.count), "numbers")
    for number in numbers:
        _check(word, float(number))
    if word.format == "gain":
        return np.array([part for number in numbers for part in to_gain(float(number), word.name)], np.int32)
    scaled = np.rint(numbers * 2.0 ** BITS[word.format])
    return np.clip(scaled, -(2**31), 2**31 - 1).astype(np.int32)  # 8 N is one step more than a word holds


def filled(words: dict[str, np.ndarray]) -> np.ndarray:
    """Return the parameter table with these words by name, 0 elsewhere, int32."""
    table = np.zeros(word_count(), dtype=np.int32)
    for name, values in words.items():
        word = word_of(name)
        table[word.first : word.first + word.words] = values
    return table


def from_words(word: Word, words: np.ndarray) -> float | np.ndarray:
    """Return the value of a parameter's words in its unit; an array where it has several numbers."""
    raw = np.asarray(words, dtype=float)
    if word.format == "gain":
        numbers = raw[::2] * 2.0 ** -raw[1::2]
    else:
        numbers = raw / 2.0 ** BITS[word.format]
    return float(numbers[0]) if word.count == 1 else numbers


def shown(word: Word, value: float | np.ndarray) -> str:
    """Return a parameter's value as text with its unit; of several numbers how many there are."""
    number = f"{value:.6g}" if isinstance(value, float) else f"{len(value)} numbers"
    return f"{number} {word.unit}".rstrip()


def accepted(word: Word) -> str:
    """Return in words what a parameter takes."""
    unit = f" {word.unit}" if word.unit else ""
    if word.format == "gain":
        return "below 2^31 in magnitude"
    kind = "a whole number" if word.format == "count" else "a number"
    low = -(2**31) if word.low is None else word.low
    high = 2**31 - 1 if word.high is None else word.high
    return f"{kind} from {low:g} to {high:g}{unit}"


def _check(word: Word, number: float) -> None:
    low = -(2**31) if word.low is None or word.format == "gain" else word.low
    high = 2**31 - 1 if word.high is None or word.format == "gain" else word.high
    whole = word.format != "count" or number == round(number) if np.isfinite(number) else False
    if not (whole and low <= number <= high):
        raise must_be(word.name, number, accepted(word), word.unit)
