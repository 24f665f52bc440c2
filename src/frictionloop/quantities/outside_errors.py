"""Errors in code from outside, told as theirs: what failed, in which file and line, in one line."""

from __future__ import annotations

import re
import traceback
from pathlib import Path
from typing import Any

from frictionloop.quantities.units import FrictionloopError

_OURS = str(Path(__file__).parents[1])
_COLOUR = re.compile(r"\x1b\[[\d;]*m")
"""Colours for a terminal, which the compiler uses where it can."""


def theirs(what: str, function: Any, error: BaseException) -> FrictionloopError:
    """Return the error of somebody's function as one line with the file and line where it was raised."""
    frames = [each for each in traceback.extract_tb(error.__traceback__) if is_outside(each.filename)]
    where = f"{frames[-1].filename}, line {frames[-1].lineno}" if frames else place(function)
    said = " ".join(str(error).split())
    told = FrictionloopError(f"{what}: {where}: {type(error).__name__}{': ' * bool(said)}{said}")
    told.__cause__ = error
    return told


def place(function: Any) -> str:
    """Return file and line of a function, or of the one that it stands for; its text if it has none."""
    plain = getattr(function, "py_func", function)
    code = getattr(getattr(plain, "stands_for", plain), "__code__", None)
    return f"{code.co_filename}, line {code.co_firstlineno}" if code else f"{function!r:.60}"


def is_outside(file: str) -> bool:
    """Tell whether a file is neither of this package nor of a library."""
    return _OURS not in str(Path(file).resolve()) and "site-packages" not in file and not file.startswith("<frozen")


def complaint(error: BaseException) -> str:
    """Return what the compiler says of somebody's code as one line: file, line and reason."""
    text = _COLOUR.sub("", str(error))
    told = re.findall(r'File "([^"]+)", line (\d+)| at (/[^\n]+) \((\d+)\)', text)
    places = [(file or other, line or number) for file, line, other, number in told]
    places = [(str(Path(file).resolve()), line) for file, line in places if is_outside(file)]
    said = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("Failed in nopython")]
    where = f"{places[-1][0]}, line {places[-1][1]}: " if places else ""
    reason = " ".join(said[: 2 if said[:1] and said[0].endswith(":") else 1])
    return f"{where}does not compile: {reason}"
