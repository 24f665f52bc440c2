"""What a change does to Fig. 5a that its numbers alone do not say, in lines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from frictionloop.parameters import System
from frictionloop.report.device import OPEN

SPEED = "motion.speed_mm_s"


def told(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return the lines.

    Parameters
    ----------
    changes
        What was changed, by dotted names.
    base
        The bench with the protocol's finger, not changed.
    rows
        The controllers of the figure, by name.
    """
    return _speed(changes, base, rows)


def _speed(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return that the friction of the finger itself changes with the speed."""
    there = base.evolve(changes)
    slope = float(there.friction.speed_slope)  # type: ignore[union-attr]  # of a finger, which the protocol sets
    if not slope or there.motion.speed_mm_s == base.motion.speed_mm_s:  # type: ignore[union-attr]
        return []
    does = "rises" if slope > 0 else "falls"
    what = "the open loop" if OPEN in rows else "what the controllers work against"
    return [f"this finger's friction {does} with speed, friction.speed_slope = {slope:.3g}: {what} changes with it"]
