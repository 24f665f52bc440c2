"""Which forces a protocol needs, which fingers can be given them, and levels fitted to what a participant's can."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from frictionloop.experiments.protocol import Protocol
from frictionloop.parameters import System
from frictionloop.physics.fingers import Fingers, fingers
from frictionloop.physics.reach import Reach, finger_reach
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect import Track

ALONG = 1001
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
    place = np.linspace(-guide.length_mm, guide.length_mm, ALONG)
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


PLACES = ("levels", "start", "least", "most", "low", "high")
"""Fields of methods that are levels."""
WIDTHS = ("spread", "step", "steps")
"""Fields that are differences of levels; a staircase's steps are that in N alone."""
FACTORS = np.linspace(1.0, 0.05, 20)
"""By which levels are drawn together, the first that fits (assumed: steps of a twentieth)."""


def fitted(protocol: Protocol, reach: Reach) -> tuple[Protocol, float]:
    """Return the protocol with levels that a finger can be given, and the factor by which they were drawn together.

    Levels beside a standard are drawn towards it. Others are drawn towards the end of their range that the finger can
    be given, so that a level of 0 stays 0; towards the middle where it can be given neither end. With
    ``out_of_reach = "mark"`` they stay as they are.

    Parameters
    ----------
    protocol : Protocol
        What is asked.
    reach : Reach
        What the finger can be given.

    Raises
    ------
    FrictionloopError
        With ``out_of_reach = "refuse"``, or where no factor helps; names forces and the share that is out of reach.
    """
    if protocol.out_of_reach == "mark" or _inside(protocol, reach):
        return protocol, 1.0
    if protocol.out_of_reach == "fit":
        for factor in FACTORS[1:].tolist():
            drawn = drawn_together(protocol, factor, _fixed(protocol, reach))
            if _inside(drawn, reach):
                return drawn, factor
    wanted, share = needed(protocol), 100 * share_out(protocol, reach)
    raise FrictionloopError(
        f"reach: {reach.low_n:.3g} to {reach.high_n:.3g} N; must be "
        f"{wanted.low_n:.3g} to {wanted.high_n:.3g} N ({share:.0f} % is out)"
    )


def share_out(protocol: Protocol, reach: Reach) -> float:
    """Return the share of the range of needed forces that a finger cannot be given."""
    low, high = needed(protocol)[:2]
    inside = float(reach.nearest(high) - reach.nearest(low))
    return 1.0 - inside / (high - low) if high > low else float(not _inside(protocol, reach))


def _fixed(protocol: Protocol, reach: Reach) -> float:
    """Return the level towards which others are drawn."""
    low, high = protocol.method.extremes()
    if protocol.stimulus.adds:
        return 0.0
    able = [end for end in (low, high) if reach.covers(*needed(protocol, end)[:2])]
    return able[0] if len(able) == 1 else 0.5 * (low + high)


def drawn_together(protocol: Protocol, factor: float, middle: float) -> Protocol:
    """Return the protocol with its levels drawn together towards one of them by a factor."""
    method = protocol.method
    changes: dict[str, Any] = {}
    for name, value in method.model_dump().items():
        if name in PLACES and not isinstance(value, int):
            changes[f"method.{name}"] = _mapped(value, middle, factor)
        elif name in WIDTHS and (name != "steps" or getattr(method, "unit", "N") == "N"):
            changes[f"method.{name}"] = _mapped(value, 0.0, factor)
    for name in ("practice_level", "catch_level"):
        if (value := getattr(protocol.blocks, name)) is not None:
            changes[f"blocks.{name}"] = _mapped(value, middle, factor)
    return protocol.evolve(changes)


def _inside(protocol: Protocol, reach: Reach) -> bool:
    return bool(reach.covers(*needed(protocol)[:2]))


def _mapped(value: Any, middle: float, factor: float) -> Any:
    if isinstance(value, (list, tuple)):
        return [middle + factor * (each - middle) for each in value]
    return middle + factor * (value - middle)
