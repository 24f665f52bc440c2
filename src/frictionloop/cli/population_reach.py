"""Which fingers of a population can be given the set-point of a system."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

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
    contact_s: float
    """Time on the plate until which both must be held."""
    contacts: int
    """How many contacts the run has."""
    whole_s: float
    """Time on the plate of a contact that the run does not cut short."""
    low: np.ndarray
    high: np.ndarray
    moving: np.ndarray
    """Who can be given both for all but a twentieth of the time while the load drifts and trembles."""
    in_the_end: np.ndarray | None
    """Who can be given both with the load at its mean once contact upon contact has made fingers as moist as they get;
    None of one that stays."""
    moving_in_the_end: np.ndarray | None
    """The same for all but a twentieth of the time while the load drifts and trembles."""

    @property
    def able(self) -> np.ndarray:
        """Who can be given both with the load at its mean."""
        able: np.ndarray = self.low & self.high
        return able

    @property
    def served(self) -> np.ndarray:
        """Who can be given both in ordinary use: as the load moves, and contact upon contact where fingers lift."""
        return self.moving if self.moving_in_the_end is None else self.moving_in_the_end


def reach_of(system: System, people: Fingers, duration_s: float) -> tuple[xr.Dataset, Reach | str]:
    """Return lowest_n and highest_n of each finger until the last contact of a run ends, and who reaches the set-point.

    A recorded set-point is as low and as high as its samples. In its place why it is not known: that
    of a function from outside, or one that the system cannot have.
    """
    motion: Any = system.motion
    contact_s, contacts, whole_s = duration_s, 1, motion.contact_s or duration_s
    if lifts := motion.contact_s > 0.0:
        contact_s = min(motion.contact_s, duration_s)
        contacts = math.ceil(duration_s / (motion.contact_s + motion.lifted_s))
    own = finger_values(system)
    touching, plate_um = [own | each for each in people], system.plate.max_amplitude_um

    def band(many: float, load_moves: bool) -> xr.Dataset:
        on_s = contact_s if many < math.inf else whole_s  # the run may end before the first contact does
        return capable(touching, max_amplitude_um=plate_um, contact_s=on_s, contacts=many, load_moves=load_moves)

    here = band(contacts, False)
    try:
        wanted = asked(at_levels(system))
    except FrictionloopError as error:
        return here, str(error)

    def reached(found: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
        return found["lowest_n"].values <= wanted.low_n, found["highest_n"].values >= wanted.high_n

    low, high = reached(here)
    moving = np.logical_and(*reached(band(contacts, True)))
    last, last_moving = (np.logical_and(*reached(band(math.inf, moves))) if lifts else None for moves in (False, True))
    return here, Reach(wanted.low_n, wanted.high_n, contact_s, contacts, whole_s, low, high, moving, last, last_moving)
