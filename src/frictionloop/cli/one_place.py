"""What a run of a stroking finger does not show: other contacts and speeds, and a loop that rings too little to see."""

from __future__ import annotations

import shlex
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from frictionloop.cli.flags import scalar

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

    from frictionloop.parameters import System

WITHOUT_CHECK = {"lookup", "oracle"}
"""Laws that close no loop, or that no linear analysis looks at."""
WIDTH = 100
NOT_ASKED = ("disturbance.", "finger.contact=")
"""Beginnings of the flags of a run that a check takes no notice of: it looks at both contacts."""


def lines(
    system: System, file: Path | None, preset: str | None, given: list[str] | None, run: xr.Dataset, mask: np.ndarray
) -> list[str]:
    """Return lines with the check that looks at other places, of the system with the flags that a run was ``given``.

    None of a system without a finger that strokes, or of a law that is not checked.
    """
    from frictionloop.parameters import Skin, Strokes
    from frictionloop.parameters.still import STILL

    finger, motion, law = system.finger, system.motion, system.controller.kind
    if not (isinstance(finger, Skin) and isinstance(motion, Strokes)) or law in WITHOUT_CHECK:
        return []
    begins = [str(file)] if file else ["--preset", preset] if preset else []
    named = [flag.partition("=") for flag in given or () if not flag.startswith(NOT_ASKED)]
    # Nor of a finger that is still so that a recording is alone: one that does not get moist would flatter the gains.
    kept = [(path, value) for path, _, value in named if path not in STILL or scalar(value) != STILL[path]]
    flags = [part for path, value in kept for part in (f"--{path}", value)]
    command = shlex.join(["frictionloop", "design", "check", *begins, *flags])
    where = f"This run is at {motion.speed_mm_s:g} mm/s on contact {finger.contact}"
    other = f"{where}{_unstable(run, mask)}; `{command}` looks at others, and a resonance that is off."
    return textwrap.wrap(other, WIDTH, break_on_hyphens=False)


def _unstable(run: xr.Dataset, mask: np.ndarray) -> str:
    """Return at which forces the linear loop is unstable, of a run that does not show it; nothing where it is not."""
    from frictionloop.analysis import operating_band
    from frictionloop.analysis.levels import at_levels
    from frictionloop.loop.record import system_of
    from frictionloop.quantities import FrictionloopError

    try:
        points = operating_band(at_levels(system_of(run), run, mask))
        forces = [f"{loop.elements.force_n:.3g}" for loop in points if not loop.is_stable()]
    except FrictionloopError:  # nothing in reach, or a law that has no linear analysis there
        return ""
    if not forces:
        return ""
    return f", where the linear loop is unstable at {', '.join(forces)} N: it rings, too little to stand out here"
