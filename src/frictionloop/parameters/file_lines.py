"""The line of a TOML file that a complaint is about, with its number and text."""

from __future__ import annotations

import os
import re
from pathlib import Path

SHOWN = 80
"""Characters of a line that are shown."""
_PLACE = re.compile(r"\(at line (\d+), column \d+\)")
_NAMED = re.compile(r"(?:unknown parameter ')?(?: +')?([A-Za-z_]\w*(?:\.\w+)*)\b")
_TABLE = re.compile(r"\s*\[\s*([\w.]+)\s*\]")
_KEY = re.compile(r"\s*([\w.]+)\s*=")


def with_line(path: str | os.PathLike[str], complaint: str) -> str:
    """Return a complaint with the line of the file that it is about behind it, where one is.

    It names the line by its number, as the parser does, or begins with the dotted name of a value; of several lines
    each does.
    """
    if "\n" in complaint:
        return "\n".join(with_line(path, each) for each in complaint.split("\n"))
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError):
        return complaint
    if parsed := _PLACE.search(complaint):
        number = int(parsed[1])
        return complaint + (f": {lines[number - 1].strip()[:SHOWN]!r}" if 0 < number <= len(lines) else "")
    named = _NAMED.match(complaint)
    number = 0 if named is None else _line_of(lines, named[1])
    return f"{complaint} (line {number}: {lines[number - 1].strip()[:SHOWN]!r})" if number else complaint


def _line_of(lines: list[str], name: str) -> int:
    """Return the number of the line, from 1, at which a dotted name is given a value or its table begins; 0 if none."""
    table = ""
    for number, line in enumerate(lines, 1):
        if begun := _TABLE.match(line):
            table = f"{begun[1]}."
            if begun[1] == name:
                return number
        elif (key := _KEY.match(line)) and table + key[1] == name:
            return number
    return 0
