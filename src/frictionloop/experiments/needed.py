"""Which forces a protocol needs, and which fingers can be given them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from frictionloop.experiments.protocol import Protocol
from frictionloop.parameters import System
from frictionloop.physics.fingers import Fingers, fingers
from frictionloop.physics.reach import finger_reach
from frictionloop.rendering.effect import Track

PLACES = 1001
"""Places along a stroke at which an effect is asked (assumed: 60 um apart on 30 mm)."""


class Needed(NamedTuple):
    """The least and the largest force that a protocol asks for, N, and where."""

    low_n: float
    high_n: float
    condition: str
    """Condition with the largest force."""


def needed(protocol: Protocol, only: float | None = None) -> Needed:
    """Return the least and the largest force that a protocol can ask for, over levels, conditions and places.

    Parameters
    ----------
    protocol : Protocol
        What is asked.
    only : float, optional
        One level, in place of all and the standard.
    """
    guide = protocol.timeline.stroke
    place = np.linspace(-guide.length_mm, guide.length_mm, PLACES)
    levels: list[float | None] = [*protocol.method.extremes()] if only is None else [only]
    if protocol.intervals == 2 and only is None:
        levels.append(None)
    found = []
    for condition in protocol.conditions:
        forces = [
            np.asarray(protocol.stimulus.at(level, condition.effect).force_of(Track().touch(place, way, guide.load_n)))
            for level in levels
            for way in (guide.speed_mm_s, -guide.speed_mm_s)
        ]
        found.append((min(float(f.min()) for f in forces), max(float(f.max()) for f in forces), condition.name))
    largest = max(found, key=lambda each: each[1])
    return Needed(min(each[0] for each in found), largest[1], largest[2])


def in_reach(protocol: Protocol, finger: Mapping[str, Any], system: System) -> bool:
    """Return whether a finger can be given all forces of a protocol, at its guide's load and speed."""
    guide, wanted = protocol.timeline.stroke, needed(protocol)
    own = {**finger, "motion.load_n": guide.load_n, "motion.speed_mm_s": guide.speed_mm_s}
    there = finger_reach(own, system.plate.max_amplitude_um, guide.duration_s)
    return bool(there.covers(wanted.low_n, wanted.high_n))


SCARCE = 50
"""Where fewer than one in so many fingers can be given all forces, fingers are taken as they come (assumed)."""


def recruited(protocol: Protocol, system: System, n: int, seed: int) -> tuple[Fingers, int, bool]:
    """Return the first n fingers of a population that can be given all forces, how many were looked at, if they can.

    Where fewer than one in `SCARCE` can, all are taken as they come.
    """
    size = n
    while size <= SCARCE * n:
        people = fingers(size, seed)
        able = [k for k, finger in enumerate(people) if in_reach(protocol, finger, system)]
        if len(able) >= n:
            return Fingers(people[k] for k in able[:n]), able[n - 1] + 1, True
        size *= 2
    return fingers(n, seed), n, False
