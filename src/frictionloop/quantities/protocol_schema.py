"""What host and firmware exchange, as protocol/frictionloop.toml describes it: parameter words and their names."""

from __future__ import annotations

import tomllib
import zlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from frictionloop.quantities.units import FrictionloopError


@dataclass(frozen=True)
class Word:
    """A parameter of the firmware: `count` doubles from word `first` on; of the format count they are whole numbers."""

    name: str
    first: int
    format: str
    text: str
    count: int = 1
    unit: str = ""
    low: float = 0.0
    high: float = 0.0


def firmware_folder() -> Path:
    """Return the folder of the C sources: in an installed package beside it, in a checkout at its root."""
    return _beside("firmware")


def schema_path() -> Path:
    """Return the path of the schema."""
    return _beside("protocol") / "frictionloop.toml"


@cache
def schema() -> dict[str, Any]:
    """Return the schema as its file has it."""
    return tomllib.loads(schema_path().read_text(encoding="utf-8"))


def named(group: str) -> dict[int, str]:
    """Return a group of the schema, such as ``faults``: name by number."""
    return {number: name for name, number in schema()[group].items()}


@cache
def parameter_words() -> dict[str, Word]:
    """Return the parameters by name, in the order of their words."""
    words: dict[str, Word] = {}
    first = 0
    for entry in schema()["parameter"]:
        given = {{"min": "low", "max": "high"}.get(key, key): value for key, value in entry.items()}
        word = Word(first=first, **given)
        words[word.name] = word
        first += word.count
    return words


def word_count() -> int:
    """Return how many words the table has."""
    last = list(parameter_words().values())[-1]
    return last.first + last.count


def table_hash() -> int:
    """Return the CRC-32 of names and formats: host and firmware with the same hash mean the same by a word."""
    lines = [f"{word.name} {word.format} {word.count}\n" for word in parameter_words().values()]
    return zlib.crc32("".join(lines).encode("ascii"))


def _beside(folder: str) -> Path:
    package = Path(__file__).resolve().parents[1]
    for place in (package / f"_{folder}", package.parents[1] / folder):
        if place.is_dir():
            return place
    raise FrictionloopError(f"{folder}: missing; reinstall frictionloop")
