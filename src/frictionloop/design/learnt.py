"""A law that learns the finger, as it is once it has: on which contacts and at which speeds it is looked at."""

from __future__ import annotations

from frictionloop.parameters import Skin, Strokes, System, TrackerController

FASTER = (1.0, 4.0)
"""Speeds that a tracker is looked at, over that of the strokes: 20 and 80 mm/s, as in the comparison of laws."""
CONTACTS = ("dahl", "slider")


def learnt(system: System) -> System:
    """Return a system whose tracker begins with the compliance that it is to learn; of other laws as it is."""
    law, finger = system.controller, system.finger
    if not (isinstance(law, TrackerController) and isinstance(finger, Skin)):
        return system
    compliance = 0.0 if finger.contact == "slider" else 1e6 / finger.bristle_stiffness_n_m
    return system.evolve({"controller.compliance_um_per_n": min(compliance, law.largest_compliance_um_per_n)})


def conditions(system: System) -> list[System]:
    """Return the contacts and speeds at which a law has to hold: its own, for a tracker, which learns both, more."""
    if not (isinstance(system.controller, TrackerController) and isinstance(system.finger, Skin)):
        return [system]
    contacts = dict.fromkeys((system.finger.contact, *CONTACTS))
    own = system.motion.speed_mm_s if isinstance(system.motion, Strokes) else None
    speeds = [{}] if own is None else [{"motion.speed_mm_s": own * faster} for faster in FASTER]
    return [learnt(system.evolve({"finger.contact": contact, **speed})) for contact in contacts for speed in speeds]
