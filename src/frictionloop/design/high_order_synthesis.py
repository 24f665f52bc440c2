"""Syntheses of higher order held to every corner: asked for less and less until what comes out holds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from frictionloop.analysis.linear import linearise
from frictionloop.design.corners import broken, corners
from frictionloop.design.hinf_wanted import HinfWanted
from frictionloop.design.noise_model import identify_noise
from frictionloop.design.quadruple import slicot
from frictionloop.design.wanted import Designed, Wanted, feedforward, unheld
from frictionloop.design.weighted_plant import check_order
from frictionloop.parameters import Skin, System
from frictionloop.quantities import FrictionloopError

TIGHTER = (1.0, 0.8, 0.6, 0.45, 0.3)
"""Shares of Ms - 1 that are tried where a synthesis does not see every corner."""


def synthesised(design: Callable[..., Any], system: System, wanted: Wanted) -> Designed:
    """Return the controller of the least tightened limits that holds at every corner, not only on the method's grid."""
    forward, notes = feedforward(system)
    # Identifying the noise already takes seconds.
    slicot()
    check_order(linearise(system).plant, system.controller.delay_s)
    noise = identify_noise(system)
    first = ""
    for share in TIGHTER:
        peaks = tuple(peak for _, peak in sorted(wanted.scaled(share).items()))
        peaks = peaks if len(peaks) == 3 else (peaks[0],) * 3
        asked = HinfWanted(peaks, wanted.resonance_error, contact=_contacts(system))
        try:
            found = design(system, noise, wanted=asked)
        except FrictionloopError as error:
            first = first or str(error)
            continue
        overrides = {**found.overrides, "controller.feedforward": forward}
        at = corners(system.evolve(overrides), wanted.limits)
        worst = broken(at)
        if worst is None:
            said = (
                f"{found.order} states, reduced from {found.full_order}; holds on contacts {', '.join(asked.contact)}"
            )
            return Designed(overrides, (*notes, said), tuple(at))
        first = first or unheld(found.method, wanted, worst)
    raise FrictionloopError(first)


def _contacts(system: System) -> tuple[str, ...]:
    own = system.finger.contact if isinstance(system.finger, Skin) else "dahl"
    return tuple(dict.fromkeys((own, "dahl", "slider")))
