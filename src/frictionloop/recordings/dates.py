"""When a file was recorded, by what it says of itself, as ISO 8601 writes it."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from datetime import datetime
from typing import Any

import numpy as np

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
