"""The tracker with its default schedule, told the resonance of a bench, one gain fitted, and what is known of it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from frictionloop.analysis.linear import linearise
from frictionloop.design.corners import broken, corners
from frictionloop.design.learnt import CONTACTS, learnt_in_run
from frictionloop.design.wanted import Designed, Wanted, unheld
from frictionloop.parameters import Skin, SuspendedSensor, System
from frictionloop.parameters.tracking import SCHEDULE
from frictionloop.quantities import FrictionloopError

SHARES = (1.0, 0.9, 0.8, 0.7)
"""Shares of the schedule's gain on the limit that are tried: each tenth less takes a tenth of Ms - 1 (measured)."""
LEARNT_S = 10.0
"""Duration of the run after which margins of what is learnt are told."""


def held_tracker(system: System, wanted: Wanted) -> Designed:
    """Return the tracker whose Ms stays below the limits with contact and finger known: its default schedule.

    It is told the resonance, its Q and the electronics. Where Ms is beyond a limit the gain on the observed limit of
    friction is lowered, the same in every row. What it learns is biased and leaves less; what is said of the design has
    Ms with that, too.

    Parameters
    ----------
    system
        The bench, with a force sensor on springs and a delay of at most one control period.
    wanted
        What must hold on both contacts, at the speed of the strokes and at four times it.

    Raises
    ------
    FrictionloopError
        The bench is none for a tracker, or no share of the gain holds: the line says where, and what limits it.
    """
    plain = system.evolve({"controller.kind": "tracker"})  # a delay that does not fit is refused here
    sensor = system.sensor
    if not isinstance(sensor, SuspendedSensor):
        raise FrictionloopError(f'sensor.kind = "{sensor.kind}": a tracker is designed for a "suspended" one')
    known = {
        "controller.kind": "tracker",
        "controller.model.resonance_hz": sensor.resonance_hz,
        "controller.model.resonance_q": sensor.q,
        "controller.model.sensor_hz": sensor.cutoff_hz,
    }
    tried = []
    for share in SHARES:
        schedule = tuple((float(f"{share * limit:.4g}"), *others) for limit, *others in SCHEDULE)
        told = plain.evolve(known | {"controller.schedule": schedule})
        found = corners(told, wanted.limits)
        worst = broken(found)
        if worst is None:
            return Designed(known | {"controller.schedule": schedule}, _learning(told), tuple(found))
        tried.append(worst)
    raise FrictionloopError(unheld("tracker", wanted, min(tried, key=lambda each: each.excess)))


def _learning(system: System) -> tuple[str, ...]:
    """Return what to say of an experimental law: margins as it starts and when it has learnt, and its known fault."""
    if not isinstance(system.finger, Skin):
        return ()
    starts = [system.evolve({"finger.contact": contact}) for contact in CONTACTS]
    believed = system.controller.model_dump()["compliance_um_per_n"]
    return (
        "these margins are those of a contact and a finger known exactly. At the mean force of a dry finger Ms is "
        f"{_told(starts)} as it starts, with {believed:g} um/N believed, and "
        f"{_told([learnt_in_run(each, LEARNT_S, 0) for each in starts])} with what it has learnt after {LEARNT_S:g} s, "
        "which is biased. The tracker is experimental: quick set-point steps can teach it the wrong contact, after "
        "which some fingers ring. notch_pi has margins that do not rest on what is learnt",
    )


def _told(systems: Sequence[System]) -> str:
    peaks = [linearise(each).margins().sensitivity_peak for each in systems]
    said = [f"{peak:.3g}" if math.isfinite(peak) else "infinite (unstable)" for peak in peaks]
    return ", ".join(f"{peak} on {contact}" for peak, contact in zip(said, CONTACTS, strict=True))
