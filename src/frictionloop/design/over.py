"""What a controller has to hold over besides forces and moistures: slip lengths, speeds, loads, in all combinations."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

from frictionloop.parameters import Skin, Strokes, System
from frictionloop.parameters.motion import TURN_SHARE, one_stroke_a_contact
from frictionloop.quantities import FrictionloopError

USUAL_UM: float = Skin.model_fields["slip_length_um"].default
"""The other end of the range of a system whose own slip length is 0."""


class Over(NamedTuple):
    """Slip lengths, speeds and loads; of what is empty that of the system."""

    slip_lengths_um: tuple[float, ...] | None = ()
    """Ends of their range. None: 0 and that of the system."""
    speeds_mm_s: tuple[float, ...] = ()
    loads_n: tuple[float, ...] = ()
    """Mean loads, N."""

    def lengths_of(self, system: System) -> tuple[float, ...]:
        """Return the slip lengths in um, the longest first; none without a skin."""
        if not isinstance(system.finger, Skin):
            return ()
        own = system.finger.slip_length_um
        ends = (0.0, own or USUAL_UM) if self.slip_lengths_um is None else self.slip_lengths_um
        return tuple(sorted(set(ends or (own,)), reverse=True))

    def systems(self, system: System) -> list[System]:
        """Return the system at every combination.

        Raises
        ------
        FrictionloopError
            Speeds or loads of a finger that does not stroke, or a stroke that cannot be.
        """
        for name, listed in (("speeds_mm_s", self.speeds_mm_s), ("loads_n", self.loads_n)):
            if listed and not isinstance(system.motion, Strokes):
                raise FrictionloopError(f'{name}: motion.kind = "{system.motion.kind}" has none; needs "strokes"')
        given: dict[str, Sequence[Any]] = {
            "finger.slip_length_um": self.lengths_of(system), "motion.speed_mm_s": self.speeds_mm_s,
            "motion.load_n": self.loads_n,
        }  # fmt: skip
        axes = [[(path, value) for value in values] for path, values in given.items() if values]
        return [at_place(system, dict(point)) for point in product(*axes)]


def at_place(system: System, place: Mapping[str, Any]) -> System:
    """Return the system at a slip length, speed and load.

    A reversal too long for a stroke at that speed is shortened to what fits: a linear loop slides, and does not turn.
    """
    speed, motion = place.get("motion.speed_mm_s"), system.motion
    if speed is None or not isinstance(motion, Strokes):
        return system.evolve(dict(place))
    longest_s = motion.stroke_mm / (TURN_SHARE * speed)
    return system.evolve({**place, "motion.reversal_s": min(motion.reversal_s, longest_s)})


def at_speed(system: System, speed_mm_s: float) -> System:
    """Return the system with strokes at a speed; where each contact is one stroke, it is as long as that takes."""
    motion = system.motion
    if not isinstance(motion, Strokes) or not one_stroke_a_contact(motion):
        return at_place(system, {"motion.speed_mm_s": speed_mm_s})
    there = motion.model_copy(update={"speed_mm_s": speed_mm_s, "contact_s": _contact_s(motion, speed_mm_s)})
    return system.evolve({"motion.speed_mm_s": speed_mm_s, "motion.contact_s": there.contact_s, **there.in_contacts()})


def _contact_s(motion: Strokes, speed_mm_s: float) -> float:
    """Return how long a stroke as long as these takes at a speed."""
    return motion.contact_s * motion.speed_mm_s / speed_mm_s


def with_longest_contact(system: System, speeds_mm_s: Sequence[float]) -> System:
    """Return the system with contacts as long as those of the slowest speed, where each contact is one stroke.

    At every speed a finger is then as moist as the slowest strokes leave it. Others stay as they are.
    """
    motion = system.motion
    slowest = min(speeds_mm_s, default=math.inf)
    if not isinstance(motion, Strokes) or not one_stroke_a_contact(motion) or slowest >= motion.speed_mm_s:
        return system
    longer = motion.model_copy(update={"contact_s": _contact_s(motion, slowest)})
    return system.evolve({"motion.contact_s": longer.contact_s, **longer.in_contacts()})


ITSELF = Over()
"""The system at its own slip length, speed and load."""
