"""What another speed of the strokes does to a changed Fig. 5a, in lines: its path, the friction, the tremor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from frictionloop.parameters import System
from frictionloop.report.device import OPEN
from frictionloop.report.protocol import with_path

STOPS = 1e-3
"""Share of the time for which a finger stops from which on it is told (chosen)."""


def speed(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return the lines; none at the speed of the protocol."""
    return [*_path(changes), *_friction(changes, base, rows)]


def _path(changes: Mapping[str, Any]) -> list[str]:
    """Return on which path a faster finger makes its stroke."""
    longer_mm = with_path(changes).get("motion.stroke_mm")
    return [f"strokes stay one long one at a time, on a path of {longer_mm:g} mm"] if longer_mm else []


def _friction(changes: Mapping[str, Any], base: System, rows: Mapping[str, Any]) -> list[str]:
    """Return that the friction of the finger itself changes with the speed, and what the tremor makes of the speed."""
    there = base.evolve(changes)
    friction: Any = there.friction  # of a finger, which the protocol sets
    motion: Any = there.motion
    usual: Any = base.motion
    slope, now, before = float(friction.speed_slope), motion.speed_mm_s, usual.speed_mm_s
    if now == before:
        return []
    does = "rises" if slope > 0 else "falls"
    what = "the open loop" if OPEN in rows else "what the controllers work against"
    lines = [f"this finger's friction {does} with speed, friction.speed_slope = {slope:.3g}: {what} changes with it"]
    return [*(lines if slope else []), *_shaken(slope, now, before, motion)]


def _shaken(slope: float, now: float, before: float, motion: Any) -> list[str]:
    """Return what the tremor along the stroke does at another speed.

    Of a narrow band about f its speed has the rms 2 pi f x_rms; a normal speed is below 0 for erfc(v/(s sqrt 2))/2 of
    the time.
    """
    rms = 2e-3 * math.pi * motion.tremor_hz * motion.tremor_um
    if not rms:
        return []
    back, usual = (0.5 * math.erfc(each / (rms * math.sqrt(2.0))) for each in (now, before))
    said = f"the tremor along the stroke makes the speed {now:g} mm/s with about {rms:.2g} mm/s rms about it"
    said += f"; by way of that slope it shakes the force {'less' if now > before else 'more'}" if slope else ""
    if max(back, usual) >= STOPS:
        said += (
            f". The finger stops or turns back for {back:.1%} of the time (unchanged {usual:.1%}): then no amplitude "
            "gives the force, and it overshoots when the finger goes on"
        )
    return [said]
