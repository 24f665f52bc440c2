"""A range of forces in words, for verbs whose answer is no result yet."""

from __future__ import annotations


def between(low_n: float, high_n: float) -> str:
    """Return a range of forces, of one force that alone."""
    ends = f"{low_n:.3g}", f"{high_n:.3g}"
    return f"{ends[0]} N" if ends[0] == ends[1] else f"{ends[0]} to {ends[1]} N"
