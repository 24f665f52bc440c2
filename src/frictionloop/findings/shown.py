"""A number, and whatever else stands in a template or a table, as a person reads it."""

from __future__ import annotations

import math
import string
from collections.abc import Mapping
from typing import Any


def shown(value: Any, digits: int = 3) -> str:  # noqa: PLR0911
    """Return a value as short as it says something: - is none, ∞ beyond all measure, yes or no.

    >>> shown(0.012345), shown(1234.5), shown(0.99951), shown(float("inf")), shown(None)
    ('0.0123', '1234', '1.000', '∞', '-')
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return " ".join(f"--{name} {_flag(each)}" for name, each in value.items())
    if isinstance(value, (list, tuple)):
        return ", ".join(shown(each, digits) for each in value)
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "-"
    if not isinstance(value, float):
        return str(value)
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if 0.9 <= value < 1.0 - 1e-6:
        near = f"{value:.{digits}f}"
        return near if near.startswith("1") else near.rstrip("0")
    return f"{value:.{digits}g}" if abs(value) < 1000.0 else f"{value:.0f}"


def _flag(value: Any) -> str:
    """Return a value as a flag takes it."""
    return str(value).lower() if isinstance(value, bool) else shown(value, 6 if isinstance(value, float) else 4)


class Template(string.Formatter):
    """``str.format`` in which a number without a format of its own is `shown`."""

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return one value."""
        return str(super().format_field(value, format_spec)) if format_spec else shown(value)


def between(low: float, high: float, unit: str = "") -> str:
    """Return a range by its ends, one that all have alone: 20 to 60 mm/s.

    >>> between(20.0, 60.0, "mm/s"), between(0.5, 0.5, "N")
    ('20 to 60 mm/s', '0.5 N')
    """
    ends = shown(low) if shown(low) == shown(high) else f"{shown(low)} to {shown(high)}"
    return f"{ends} {unit}".rstrip()
