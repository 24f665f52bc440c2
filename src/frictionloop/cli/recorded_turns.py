"""Which seconds of a recorded disturbance are not scored, as the simulated finger turns round there."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING

from frictionloop.analysis.levels import RECORDED
from frictionloop.cli.contact_turns import beside
from frictionloop.cli.recorded import WIDTH
from frictionloop.parameters import Skin, Strokes
from frictionloop.physics.motion import scored_edge_m, stroke_plan
from frictionloop.recordings.clean import SHOWN, stretches

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

STEP_MM = 10.0
"""Strokes are named in whole centimetres."""


def lines(run: xr.Dataset, system: System, duration_s: float) -> list[str]:
    """Return when a recorded disturbance is not scored, and a stroke without a turn; nothing of another run."""
    if system.disturbance.kind not in RECORDED or "scored" not in run or run["scored"].values.all():
        return []
    time = run["time"].values
    parts = stretches(~run["scored"].values.astype(bool))
    more = f" and {len(parts) - SHOWN} more" if len(parts) > SHOWN else ""
    at = ", ".join(f"{time[a]:.3g} to {time[b]:.3g} s" for a, b in parts[:SHOWN])
    said = f"Not scored are {at}{more} of this run: its finger starts, turns round or is lifted there, and the "
    said += "recording runs on."
    if any(a > 0 for a, _ in parts):
        said += " What is left below and above a frequency has a straight line there."
    stroke_mm = without_turn_mm(system, duration_s)
    if stroke_mm is not None:
        flags = {"motion.stroke_mm": stroke_mm} | beside(stroke_mm, system)
        listed = " ".join(f"--{path} {value:.6g}" for path, value in flags.items())
        said += f" {listed} has no turn in this run: go by that."
    return textwrap.wrap(said, WIDTH)


def without_turn_mm(system: System, duration_s: float) -> float | None:
    """Return a stroke that does not end within a run, where one that starts at its end and stays down is too short."""
    motion, finger = system.motion, system.finger
    if not isinstance(motion, Strokes) or not isinstance(finger, Skin) or motion.start or motion.contact_s:
        return None
    edge_mm = 1e3 * (stroke_plan(motion).half_stroke_m - scored_edge_m(motion, finger))
    needed_mm = motion.speed_mm_s * duration_s + edge_mm
    return None if motion.stroke_mm >= needed_mm else STEP_MM * math.ceil(needed_mm / STEP_MM)
