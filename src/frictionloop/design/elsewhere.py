"""What a controller holds on the contact and at the speed that it was not designed for."""

from __future__ import annotations

from collections.abc import Mapping

from frictionloop.design.corners import broken, corners, stroke_of
from frictionloop.design.learnt import conditions, strokes_of
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError


def elsewhere(system: System, limits: Mapping[float, float]) -> tuple[str, ...]:
    """Return a line that says where else a System's controller is beyond its limits on Ms, none if nowhere.

    Elsewhere are the other contact and four times the speed, of those at which its synthesis has not looked.
    """
    looked, beyond = {stroke_of(each) for each in conditions(system)}, []
    for there in strokes_of(system):
        if (stroke := stroke_of(there)) in looked:
            continue
        try:
            worst = broken(corners(there, limits), limits)
        except FrictionloopError:  # a force out of reach, a law that is saturated there
            continue
        if worst is not None:
            off = f" with the resonance {worst.off:+.0%} off" if worst.off else ""
            beyond.append(f"{worst.margins.sensitivity_peak:.3g}{off} on{stroke.removeprefix(', contact')}")
    if not beyond:
        return ()
    return (f"not held elsewhere, where it was not designed for: Ms gets to {'; '.join(beyond)}",)
