"""Which people can be given the set-point of a system: a steady load, a moving load, contact upon contact."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionloop.analysis.operating_point import at_levels, force_band
from frictionloop.findings import Finding
from frictionloop.findings.result import Table, frame
from frictionloop.parameters import System
from frictionloop.physics.fingers import Fingers
from frictionloop.physics.reach import Reach, population_reach
from frictionloop.quantities import FrictionloopError

MOIST_S = 40.0
"""On the plate in a run from when on a finger is as moist as it gets (chosen)."""
LATER, LIFTING = "--duration-s 60 --score-from-s 40", {"motion.contact_s": 10.0}
"""What scores a run of fingers that are moist, and what counts them contact upon contact."""


@dataclass(frozen=True)
class PeopleReach:
    """Who can be given the lowest and the highest force that a set-point asks for, a bool for each finger."""

    low_n: float
    high_n: float
    contact_s: float
    """Time on the plate until which both must be held."""
    contacts: int
    """How many contacts the run has."""
    low: np.ndarray
    """The lowest, with the load at its mean."""
    high: np.ndarray
    moving: np.ndarray
    """Both for all but a twentieth of the time while the load drifts and trembles."""
    in_the_end: np.ndarray | None
    """Both with the load at its mean once contact upon contact has made fingers as moist as they get; None of a finger
    that stays."""
    moving_in_the_end: np.ndarray | None
    """The same for all but a twentieth of the time while the load drifts and trembles."""

    @property
    def able(self) -> np.ndarray:
        """Both with the load at its mean."""
        able: np.ndarray = self.low & self.high
        return able

    @property
    def served(self) -> np.ndarray:
        """Both in ordinary use, the strictest of the four: the load moves, and fingers that lift are moist."""
        return self.moving if self.moving_in_the_end is None else self.moving_in_the_end

    def table(self) -> Table:
        """Return how many are able under a steady load and as it moves."""
        rows = {f"{self.contacts} x {self.contact_s:g} s on the plate": (self.able, self.moving)}
        if self.in_the_end is not None and self.moving_in_the_end is not None:
            rows["contact upon contact"] = (self.in_the_end, self.moving_in_the_end)
        counts = {name: [int(each.sum()) for each in pair] for name, pair in rows.items()}
        return frame(counts, "able", ["steady load", "load moves"])


def people_reach(system: System, people: Fingers, duration_s: float) -> tuple[Reach, PeopleReach | Finding]:
    """Return the reach of each finger until the last contact of a run ends, and who reaches the set-point.

    A recorded set-point is as low and as high as its samples. In its place why it is not known: that of a function
    from outside, or one that the system cannot have.
    """
    motion: Any = system.motion
    contact_s, contacts, whole_s = duration_s, 1, motion.contact_s or duration_s
    if lifts := motion.contact_s > 0.0:
        contact_s = min(motion.contact_s, duration_s)
        contacts = math.ceil(duration_s / (motion.contact_s + motion.lifted_s))
    touching, plate_um = with_own(system, people), system.plate.max_amplitude_um

    def after(many: float, load_moves: bool) -> Reach:
        on_s = contact_s if many < math.inf else whole_s  # the run may end before the first contact does
        return population_reach(touching, plate_um, on_s, many, load_moves=load_moves)

    here = after(contacts, False)
    try:
        wanted = force_band(at_levels(system))
    except FrictionloopError as error:
        return here, Finding("REACH-UNKNOWN", more={"reason": str(error)})
    ends = wanted.low_n, wanted.high_n
    low, high, moving = here.low_n <= ends[0], here.high_n >= ends[1], after(contacts, True).covers(*ends)
    last, last_moving = (after(math.inf, moves).covers(*ends) if lifts else None for moves in (False, True))
    return here, PeopleReach(*ends, contact_s, contacts, low, high, moving, last, last_moving)


def with_own(system: System, people: Fingers) -> list[dict[str, Any]]:
    """Return fingers with the system's friction and motion where they bring none, as `capable` reads them."""
    blocks = {"friction": system.friction, "motion": system.motion}
    own = {f"{name}.{key}": value for name, block in blocks.items() for key, value in block}
    return [own | each for each in people]


def moist_later(reach: PeopleReach) -> Iterator[Finding]:
    """Yield that fingers get moister than they are in the run that is scored."""
    on_s = reach.contacts * reach.contact_s
    if reach.in_the_end is None:
        yield Finding("PEOPLE-DRY", value=on_s, unit="s", remedy=LIFTING)
    elif on_s < MOIST_S:
        yield Finding("PEOPLE-DRY", value=on_s, unit="s", remedy=LATER)


def share_of_all(count: int, total: int) -> tuple[float, float]:
    """Return the 95 % interval of the share of all such people, from a draw of some (Wilson 1927)."""
    from scipy.stats import binomtest

    low, high = binomtest(count, total).proportion_ci(0.95, "wilson")
    return float(low), float(high)
