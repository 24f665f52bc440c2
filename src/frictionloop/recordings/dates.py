"""Times of the clock on the wall and dates, as ISO 8601 writes them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from datetime import datetime
from typing import Any

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


_DATES = {"date", "wfstarttime", "datetime", "recorded", "starttime"}
_FORMS: tuple[str, ...] = ("%Y/%m/%d %H:%M:%S", "%Y/%m/%d", "%a %b %d %H:%M:%S %Y", "%d.%m.%Y %H:%M:%S", "%d.%m.%Y")
_FORMS += ("%d-%b-%y %H:%M:%S", "%d-%b-%Y %H:%M:%S", "%d-%b-%y", "%d-%b-%Y", "%Y%m%d")
"""Dates that can be read in one way alone."""


def iso_date(text: str) -> str:
    """Return a date, with its time where that stands there, to the second; "" of what is none, or may be two.

    >>> iso_date("2024/03/05 10:00:00,5"), iso_date("Tue Mar  5 10:11:12 2024"), iso_date("3/5/2024")
    ('2024-03-05T10:00:00', '2024-03-05T10:11:12', '')
    """
    text = re.sub(r"(:\d\d)[.,]\d+", r"\1", " ".join(text.split()))
    for form in ("", *_FORMS):
        with suppress(ValueError):
            found = datetime.strptime(text, form) if form else datetime.fromisoformat(text)
            return found.date().isoformat() if ":" not in text and "T" not in text else found.isoformat()
    return ""


def told_date(pairs: Iterable[tuple[str, Any]]) -> str:
    """Return the first date that names and values tell, "" without one."""
    for name, value in pairs:
        if re.sub(r"[^a-z]", "", name.rpartition("/")[2].lower()) in _DATES and np.size(value) == 1:
            found = np.ravel(value)[0]
            text = found.decode("utf-8", "replace") if isinstance(found, bytes) else str(found)
            if date := iso_date(text):
                return date
    return ""
