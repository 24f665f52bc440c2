"""Where a recording has no numbers, in s, and which part of it could be taken as it is."""

from __future__ import annotations

import numpy as np

from frictionloop.recordings.column import Array

SHOWN = 3
"""Gaps that are listed."""
LEAST = 10
"""Steps of a part that may be taken for a recording (chosen)."""


def clean_part(values: Array, first: int, rate_hz: float) -> tuple[str, str]:
    """Return in words where values are no numbers, and what cuts out the longest part without such; "" without either.

    Parameters
    ----------
    values
        Samples, the first of which is number ``first`` of the file.
    first, rate_hz
        Where they stand in the file, and samples per second.
    """
    bad = ~np.isfinite(values)
    if not bad.any():
        return "", ""
    gaps, clean = _stretches(bad), _stretches(~bad)
    start, stop = max(clean, key=lambda part: part[1] - part[0], default=(0, 0))
    if stop - start < LEAST:
        return "", ""
    more = f" and {len(gaps) - SHOWN} more" if len(gaps) > SHOWN else ""
    where = f"; no number at {', '.join(_said(first + a, first + b, rate_hz) for a, b in gaps[:SHOWN])}{more}"
    cut = f"--disturbance.start_s {(first + start) / rate_hz:.9g} --disturbance.stop_s {(first + stop) / rate_hz:.9g}"
    return where, f", or the longest part without a gap: {cut} (or --setpoint)"


def _said(start: int, stop: int, rate_hz: float) -> str:
    """Return a stretch in words."""
    return f"{start / rate_hz:.9g} s" if start == stop else f"{start / rate_hz:.9g} to {stop / rate_hz:.9g} s"


def _stretches(of: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and last index of each stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], of, [False]]).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]
