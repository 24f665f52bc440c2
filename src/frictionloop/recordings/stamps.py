"""Times of the clock on the wall, as ISO 8601 writes them, as seconds."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

ACCEPTED = "a number, or a time as 2024-03-05T10:11:12.345"
"""Forms of a cell of times."""
_STAMP = re.compile(r"(\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:[.,]\d{1,9})?)?)\s*(?:Z|([+-]\d\d):?(\d\d)?)?")
_NOT = np.datetime64("NaT", "ns")


def stamp_of(cell: str) -> np.datetime64:
    """Return the time that a cell holds, in UTC where it says a zone; NaT if it holds none."""
    found = _STAMP.fullmatch(cell.strip())
    if found is None:
        return _NOT
    local, hours, minutes = found.groups()
    try:
        time = np.datetime64(local.replace(",", "."), "ns")
    except ValueError:  # a month 13
        return _NOT
    east = 0 if hours is None else 60 * int(hours) + int(f"{hours[0]}{minutes or 0}")
    return time + np.timedelta64(-east, "m")


def is_stamp(cell: str) -> bool:
    """Return whether a cell holds such a time."""
    return not np.isnat(stamp_of(cell))


def seconds_after(start: np.datetime64, cells: Iterable[str]) -> NDArray[np.float64]:
    """Return the times in cells in s after one of them, NaN where there is none; to a ns over some months."""
    times = np.array([stamp_of(each) for each in cells], dtype="datetime64[ns]")
    return np.asarray((times - start) / np.timedelta64(1, "s"), dtype=float)


def shown(time: np.datetime64) -> str:
    """Return a time in whole seconds."""
    return str(np.datetime_as_string(time, unit="s"))
