"""What a controller holds on the contact and at the speed that it was not designed for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from frictionloop.design.corners import Corner, broken, corners
from frictionloop.design.learnt import strokes_of
from frictionloop.parameters import Skin, Strokes, System, TrackerController
from frictionloop.quantities import FrictionloopError


class Elsewhere(NamedTuple):
    """Where a controller does not hold, in words; nothing where it does."""

    unstable: tuple[str, ...] = ()
    """Contacts and speeds at which a loop is unstable, and from which error of the resonance on."""
    beyond: tuple[str, ...] = ()
    """Those at which it is stable and Ms is beyond its limit."""
    unseen: tuple[str, ...] = ()
    """Those that cannot be looked at, with the reason."""

    def warning(self) -> tuple[str, ...]:
        """Return the line that comes before all others."""
        places = "; ".join(self.unstable)
        return (f"UNSTABLE {places}. Do not use it there: it was not designed for it.",) if self.unstable else ()

    def notes(self) -> tuple[str, ...]:
        """Return what else is worth a line."""
        beyond = (f"beyond its limits elsewhere: {'; '.join(self.beyond)}",) if self.beyond else ()
        return (*beyond, *self.unseen)


def elsewhere(system: System, limits: Mapping[float, float]) -> Elsewhere:
    """Return where else a System's controller is beyond its limits on Ms, or cannot be looked at.

    Elsewhere are the other contact and four times the speed; a tracker is designed for all of them.
    """
    unstable, beyond, unseen = [], [], []
    for changes in [] if isinstance(system.controller, TrackerController) else strokes_of(system):
        try:
            there = system.evolve(changes)
            found = [] if there == system else corners(there, limits)
        except FrictionloopError as error:  # no such stroke, a force out of reach, a law that is saturated there
            given = ", ".join(f"{path} = {value}" for path, value in changes.items())
            unseen.append(f"not looked at with {given}: {error}")
            continue
        rings = [each for each in found if math.isinf(each.sensitivity_peak)]
        if rings:
            unstable.append(_place(there, min(rings, key=lambda each: abs(each.off))))
        elif found and (worst := broken(found)):
            beyond.append(f"Ms {worst.sensitivity_peak:.3g} {_place(there, worst)}")
    return Elsewhere(tuple(unstable), tuple(beyond), tuple(unseen))


def _place(system: System, corner: Corner) -> str:
    """Return contact, speed and resonance of a corner, as in "on a slider at 80 mm/s, the resonance 10 % lower"."""
    finger, motion = system.finger, system.motion
    contact = f"on contact {finger.contact}" if isinstance(finger, Skin) else ""
    speed = f" at {motion.speed_mm_s:g} mm/s" if isinstance(motion, Strokes) else ""
    side = "higher" if corner.off > 0 else "lower"
    off = f" with the resonance {100 * abs(corner.off):.3g} % {side}" if corner.off else ""
    return contact + speed + off
