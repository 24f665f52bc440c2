"""What a run of a stroking finger does not show: other slip lengths and speeds, a loop that rings too little to see."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from frictionloop.cli.flags import again, scalar

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from frictionloop.parameters import System

WITHOUT_CHECK = {"lookup"}
"""Laws that close no loop."""
WIDTH = 100


def lines(
    system: System, file: Path | None, preset: str | None, given: list[str] | None, run: xr.Dataset, mask: np.ndarray
) -> list[str]:
    """Return lines with the check that looks at other places, of the system with the flags that a run was ``given``.

    None of a system without a finger that strokes, or of a law that is not checked.
    """
    from frictionloop.parameters import Skin, Strokes

    finger, motion, law = system.finger, system.motion, system.controller.kind
    if not (isinstance(finger, Skin) and isinstance(motion, Strokes)) or law in WITHOUT_CHECK:
        return []
    command = f"frictionloop design check {again(file, preset, given, unasked)}"
    where = f"This run is at {motion.speed_mm_s:g} mm/s with slip length {finger.slip_length_um:g} um"
    other = f"{where}{_unstable(run, mask)}; `{command}` looks at others, and a resonance that is off{without(given)}."
    return textwrap.wrap(other, WIDTH, break_on_hyphens=False)


def without(flags: Iterable[str] | None) -> str:
    """Return that a check leaves out the disturbance that is given with flags, which moves the forces it looks at."""
    return ", without this disturbance" * any(flag.startswith("disturbance.") for flag in flags or ())


def unasked(path: str, value: str) -> bool:
    """Tell whether a flag of runs is left out of the check that they name.

    The disturbance is, and a finger that is still so that a recording is alone: one that does not get moist would
    flatter the gains.
    """
    from frictionloop.parameters.still import STILL

    return path.startswith("disturbance.") or STILL.get(path) == scalar(value)


def _unstable(run: xr.Dataset, mask: np.ndarray) -> str:
    """Return at which forces the linear loop is unstable, of a run that does not show it; nothing where it is not.

    Looked at is a finger just landed, then one as moist as at the end of the run.
    """
    from frictionloop.analysis import operating_band
    from frictionloop.analysis.levels import at_levels
    from frictionloop.analysis.reach import missed
    from frictionloop.loop.record import system_of
    from frictionloop.quantities import FrictionloopError

    moist = _occluded(system_of(run), run.sizes["time"] / system_of(run).controller.rate_hz)
    for occluded, when in ((0.0, ""), (moist, f", with a finger {moist:.0%} occluded as at its end")):
        try:
            levels = at_levels(system_of(run), run, mask)
            # In the place of one that is out of reach stands the limit of the amplitude, where no loop is closed.
            limits = {each.instead_n for each in missed(levels, [occluded])}
            points = operating_band(levels, occluded=(occluded,))
            inside = [loop for loop in points if not any(math.isclose(loop.elements.force_n, each) for each in limits)]
            forces = [f"{loop.elements.force_n:.3g}" for loop in inside if not loop.is_stable()]
        except FrictionloopError:  # nothing in reach, or a law that has no linear analysis there
            continue
        if forces:
            where = f"{', '.join(forces)} N{when}"
            return f", where the linear loop is unstable at {where}: it rings, too little to stand out here"
    return ""


def _occluded(system: System, duration_s: float) -> float:
    """Return how moist a finger is at the end of a run, 0 to 1."""
    from frictionloop.parameters import FingerFriction, Strokes
    from frictionloop.physics.occlusion import occlusion_at

    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return 0.0
    return occlusion_at(friction, motion.contact_s, motion.lifted_s, duration_s)
