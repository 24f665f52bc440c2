"""What a controller holds on the contact and at the speed that it was not designed for."""

from __future__ import annotations

from collections.abc import Mapping

from frictionloop.design.corners import broken, corners, stroke_of
from frictionloop.design.learnt import strokes_of
from frictionloop.parameters import System, TrackerController
from frictionloop.quantities import FrictionloopError


def elsewhere(system: System, limits: Mapping[float, float]) -> tuple[str, ...]:
    """Return lines that say where else a System's controller is beyond its limits on Ms, or cannot be looked at.

    Elsewhere are the other contact and four times the speed; a tracker is designed for all of them.
    """
    beyond, unseen = [], []
    for changes in [] if isinstance(system.controller, TrackerController) else strokes_of(system):
        try:
            there = system.evolve(changes)
            worst = None if there == system else broken(corners(there, limits), limits)
        except FrictionloopError as error:  # no such stroke, a force out of reach, a law that is saturated there
            given = ", ".join(f"{path} = {value}" for path, value in changes.items())
            unseen.append(f"not looked at with {given}: {error}")
            continue
        if worst is not None:
            off = f" with the resonance {worst.off:+.0%} off" if worst.off else ""
            beyond.append(f"{worst.margins.sensitivity_peak:.3g}{off} on{stroke_of(there).removeprefix(', contact')}")
    said = [f"not held elsewhere, where it was not designed for: Ms gets to {'; '.join(beyond)}"] if beyond else []
    return (*said, *unseen)
