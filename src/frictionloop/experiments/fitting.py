"""Levels fitted to what a participant's finger can be given, or refused with the share that is out of reach."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.experiments.needed import needed
from frictionloop.experiments.protocol import Protocol
from frictionloop.physics.reach import Reach
from frictionloop.quantities import FrictionloopError

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
