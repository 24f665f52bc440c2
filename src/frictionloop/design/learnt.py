"""A law that learns the finger: as it would be if it knew it, and as it is; on which contacts and at which speeds."""

from __future__ import annotations

import math
from typing import Any

from frictionloop.control.tracker_state import TrackerState
from frictionloop.loop.simulate import law_state
from frictionloop.parameters import FrictionLaw, Skin, Strokes, System, TrackerController

FASTER = (1.0, 4.0)
"""Speeds that a tracker is looked at, over that of the strokes: 20 and 80 mm/s, as in the comparison of laws."""
CONTACTS = ("dahl", "slider")


def knowing(system: System) -> System:
    """Return a system whose tracker begins with the compliance and the susceptibility that are true; others stay."""
    law, finger = system.controller, system.finger
    friction = system.friction
    if not (isinstance(law, TrackerController) and isinstance(finger, Skin) and isinstance(friction, FrictionLaw)):
        return system
    compliance = 0.0 if finger.contact == "slider" else 1e6 / finger.bristle_stiffness_n_m
    return system.evolve(
        {
            "controller.compliance_um_per_n": min(compliance, law.largest_compliance_um_per_n),
            "controller.model.susceptibility_per_um2": friction.susceptibility_per_um2,
        }
    )


def learnt_in_run(system: System, duration_s: float, seed: int) -> System:
    """Return a system whose tracker begins with what it believes at the end of a run; of other laws as it is.

    Compliance and susceptibility that are learnt in the loop are biased, for its innovations are not white
    (studies/pages/laws.md): this is the loop that runs, `knowing` the one that was designed.
    """
    law = system.controller
    if not isinstance(law, TrackerController):
        return system
    found = dict(zip(TrackerState._fields, law_state(system, duration_s, seed).tolist(), strict=False))
    return system.evolve(
        {
            "controller.compliance_um_per_n": min(found["compliance"], law.largest_compliance_um_per_n),
            "controller.model.susceptibility_per_um2": found["fall"] * math.log(2.0),
        }
    )


def conditions(system: System) -> list[System]:
    """Return the contacts and speeds at which a law has to hold: its own, for a tracker, which learns both, more."""
    if not isinstance(system.controller, TrackerController):
        return [system]
    return [knowing(system.evolve(changes)) for changes in strokes_of(system)] or [system]


def strokes_of(system: System) -> list[dict[str, Any]]:
    """Return overrides for both contacts, at the speed of a system and at four times that; none without a skin."""
    if not isinstance(system.finger, Skin):
        return []
    contacts = dict.fromkeys((system.finger.contact, *CONTACTS))
    own = system.motion.speed_mm_s if isinstance(system.motion, Strokes) else None
    speeds = [{}] if own is None else [{"motion.speed_mm_s": own * faster} for faster in FASTER]
    return [{"finger.contact": contact, **speed} for contact in contacts for speed in speeds]
