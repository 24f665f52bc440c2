"""Which fingers of a population can be given the set-point of a system."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from frictionloop.analysis.levels import at_levels
from frictionloop.analysis.operating import asked
from frictionloop.cli.describe import finger_values
from frictionloop.parameters import System
from frictionloop.physics.capable import capable
from frictionloop.physics.fingers import Fingers
from frictionloop.quantities import FrictionloopError


class Reach(NamedTuple):
    """Which fingers can be given the lowest and the highest force that a set-point asks for."""

    low_n: float
    high_n: float
    hold_s: float
    low: np.ndarray
    high: np.ndarray
    moving: np.ndarray
    """Who can be given both for all but a twentieth of the time while the load drifts and trembles."""

    @property
    def able(self) -> np.ndarray:
        """Who can be given both with the load at its mean."""
        able: np.ndarray = self.low & self.high
        return able


def reach_of(system: System, people: Fingers, duration_s: float) -> tuple[xr.Dataset, Reach | str]:
    """Return lowest_n and highest_n of each finger, held as long as it touches, and who reaches the set-point.

    A recorded set-point is as low and as high as its samples. In its place why it is not known: that
    of a function from outside, or one that the system cannot have.
    """
    contact_s: float = system.motion.contact_s  # type: ignore[union-attr]
    hold_s = min(contact_s, duration_s) if contact_s > 0 else duration_s
    own = finger_values(system)
    touching, plate_um = [own | each for each in people], system.plate.max_amplitude_um
    band, moved = (
        capable(touching, max_amplitude_um=plate_um, contact_s=hold_s, load_moves=moves) for moves in (False, True)
    )
    try:
        wanted = asked(at_levels(system))
    except FrictionloopError as error:
        return band, str(error)
    low, high, moved_low, moved_high = (
        found
        for each in (band, moved)
        for found in (each["lowest_n"].values <= wanted.low_n, each["highest_n"].values >= wanted.high_n)
    )
    return band, Reach(wanted.low_n, wanted.high_n, hold_s, low, high, moved_low & moved_high)
