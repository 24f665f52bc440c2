"""Reading a small file that a person named: looked at before it is read, so that no pipe, device or giant is."""

from __future__ import annotations

import json
import os
import stat
from pathlib import Path
from typing import Any

from frictionloop.quantities.units import FrictionloopError

LARGEST_BYTES = 10**6
"""Of a parameter file; all keys of all blocks, and arrays of thousands of samples, fit (assumed)."""


def text_of(path: str | os.PathLike[str], most_bytes: int = LARGEST_BYTES) -> str:
    """Return the text of a file in UTF-8, without a byte-order mark.

    Raises
    ------
    FrictionloopError
        For a path that leads to no file or cannot be read, a file that is larger, or no UTF-8.
    """
    try:
        about = Path(path).stat()
        if not stat.S_ISREG(about.st_mode) and not stat.S_ISDIR(about.st_mode):
            raise FrictionloopError(f"{path}: is no file")
        if about.st_size > most_bytes:
            raise FrictionloopError(f"{path}: has more than {most_bytes:,} bytes")
        return Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FrictionloopError(f"{path}: cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError as error:
        raise FrictionloopError(f"{path}: is no UTF-8 (byte {error.start})") from None


def json_of(path: str | os.PathLike[str], most_bytes: int = 100 * LARGEST_BYTES) -> Any:
    """Return what a JSON file holds.

    Raises
    ------
    FrictionloopError
        As `text_of`, and for what is no JSON.
    """
    try:
        return json.loads(text_of(path, most_bytes))
    except (ValueError, RecursionError) as error:  # a number of thousands of digits too
        if isinstance(error, FrictionloopError):
            raise
        raise FrictionloopError(f"{path}: is not JSON ({error})") from None
