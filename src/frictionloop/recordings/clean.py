"""Where a recording has no numbers, in s, and which part of it could be taken as it is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.contents import Array

SHOWN = 3
"""Gaps that are listed."""
LEAST = 10
"""Steps of a part that may be taken for a recording (chosen)."""


def clean_part(values: Array, at_s: Array) -> tuple[str, str]:
    """Return where values are no numbers, in words, and what cuts out the longest part without such; else ""."""
    bad = ~np.isfinite(values)
    if not bad.any():
        return "", ""
    gaps = stretches(bad)
    start, stop = longest(~bad)
    if stop - start < LEAST:
        return "", ""
    more = f" and {len(gaps) - SHOWN} more" if len(gaps) > SHOWN else ""
    where = f"; no number at {', '.join(stretch(at_s[a], at_s[b]) for a, b in gaps[:SHOWN])}{more}"
    return where, f", or {taking(at_s[start], at_s[stop])}"


def refuse_gaps(
    path: str,
    values: Array,
    place: Callable[[int], str],
    where: str = "",
    cut: str = "",
    accepted: str = "a finite number",
) -> None:
    """Refuse a NaN or an infinity, naming the first and where it stands, where all are, and what cuts them out."""
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        more = f" (and {bad.size - 1} more)" if bad.size > 1 else ""
        raise FrictionloopError(f"{path}: {place(int(bad[0]))}{more}{where}; accepted: {accepted}{cut}")


def taking(start_s: float, stop_s: float) -> str:
    """Return what takes the longest part without a gap."""
    flags = f"--disturbance.start_s {start_s:.9g} --disturbance.stop_s {stop_s:.9g}"
    return f"the longest part without a gap: {flags} (or --setpoint)"


def stretch(start_s: float, stop_s: float) -> str:
    """Return a stretch in words."""
    return f"{start_s:.9g} s" if start_s == stop_s else f"{start_s:.9g} to {stop_s:.9g} s"


def longest(of: np.ndarray) -> tuple[int, int]:
    """Return the first and last index of the longest stretch of True, (0, 0) without any."""
    return max(stretches(of), key=lambda part: part[1] - part[0], default=(0, 0))


def stretches(of: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last index of each stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], of, [False]]).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]
