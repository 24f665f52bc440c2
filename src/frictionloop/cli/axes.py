"""The axes of a sweep, as written after ``--over``: ``controller.kp=1:100:32:log`` or ``controller.ki=0.1,1,10``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from frictionloop.cli.flags import scalar
from frictionloop.quantities.units import FrictionloopError

ACCEPTED = "accepted: NAME=a,b,c or NAME=start:stop:count or NAME=start:stop:count:log"
MOST_RUNS = 20_000_000
"""Runs in one sweep: at about 350 bytes each while it lasts, 7 GB."""


def axes_of(given: Sequence[str], seeds: int = 1) -> dict[str, list[Any]]:
    """Return the values along each dotted path, in the order given; refuse more runs than a sweep can hold."""
    axes: dict[str, list[Any]] = {}
    for text in given:
        path, equals, values = text.partition("=")
        path = path.strip().removeprefix("--").replace("-", "_")
        if not (path and equals and values.strip()):
            raise FrictionloopError(f"over = {text!r}: {ACCEPTED}")
        if path in axes:
            raise FrictionloopError(f"over = {text!r}: {path} is swept twice; give all its values at once")
        axes[path] = (
            _range(text, values.split(":")) if ":" in values else [scalar(v.strip()) for v in values.split(",")]
        )
    runs = seeds * math.prod(map(len, axes.values()))
    if runs > MOST_RUNS:
        raise FrictionloopError(f"over: {runs} runs are more than {MOST_RUNS}; take fewer values or fewer seeds")
    return axes


def _range(text: str, parts: list[str]) -> list[float]:
    try:
        start, stop, count = float(parts[0]), float(parts[1]), int(parts[2])
        (log,) = [{"log": True, "lin": False}[spacing] for spacing in parts[3:]] or [False]
    except (ValueError, IndexError, KeyError):
        raise FrictionloopError(f"over = {text!r}: {ACCEPTED}") from None
    if not (2 <= count <= MOST_RUNS and math.isfinite(start) and math.isfinite(stop)):
        raise FrictionloopError(f"over = {text!r}: start and stop must be finite, count from 2 to {MOST_RUNS}")
    if log and not (start > 0 and stop > 0):
        raise FrictionloopError(f"over = {text!r}: start and stop must be positive for log spacing")
    import numpy as np

    values: list[float] = (np.geomspace if log else np.linspace)(start, stop, count).tolist()
    return values
