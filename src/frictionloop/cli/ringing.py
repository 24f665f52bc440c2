"""What the linear analysis says of a loop that rings or nearly does: Ms, its frequency, and PI gains that hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.analysis.linear import LinearLoop
    from frictionloop.parameters import System

HELD_PEAK = 2.0
"""Ms of the gains that are named instead, dry and moist: a phase margin of at least 29 degrees."""
OFF = 0.1
"""Share by which the resonance of the sensor may be off where gains are said to hold."""


class Band(NamedTuple):
    """The operating points that were looked at: the levels of the set-point, and states of the finger."""

    low_n: float
    high_n: float
    dry_and_moist: bool
    occluded: float
    """How moist the moist finger is, 0 to 1: a law is judged at the end of a contact, as it is designed; a PI at 1."""
    where: str
    """Contact, speed and resonance of the sensor, in words."""
    out_of_reach_n: tuple[float, ...] = ()
    """Forces asked for that are out of reach of every finger looked at; the nearest within stands for them."""


class Ringing(NamedTuple):
    """A loop that rings or nearly does."""

    stable: bool
    frequency_hz: float | None
    """Of the loop's least damped pole, or near it where a run has most power; None if neither is known."""
    law: str
    """Kind of the controller."""
    sensitivity_peak: float | None
    """Largest Ms of the points looked at; None if one is unstable."""
    kp: float | None
    ki: float | None
    """Gains of a PI law."""
    held: dict[str, float]
    """Gains that hold, as overrides; empty if none were found, or the law is not PI."""
    band: Band
    """Where they hold."""
    not_held: tuple[str, ...]
    """Slip lengths and speeds at which they do not."""
    also_held: tuple[str, ...] = ()
    """Other slip lengths and speeds at which they do, with the resonance off by `OFF`: Ms stays below `NEAR` there."""
    springs: bool = False
    """Whether the sensor resonates, so that a design has a notch."""
    moist_alone: bool = False
    """Whether it is unstable on a moist finger alone, and not on one that has just landed."""


def of_system(system: System) -> Ringing | None:
    """Return what the linear analysis says of a system, dry and moist; None if it neither rings nor nearly does."""
    from frictionloop.analysis.reach import missed
    from frictionloop.analysis.stability import NEAR, ringing_hz
    from frictionloop.design.elsewhere import elsewhere
    from frictionloop.design.pi_synthesis import retune
    from frictionloop.parameters import PiController, SuspendedSensor

    controller = system.controller
    try:
        points = points_of(system)
        peak = max(point.sensitivity_peak() for point in points)
    except FrictionloopError:  # what cannot be linearised (a recording) is not judged
        return None
    stable = math.isfinite(peak)
    if stable and peak < NEAR:
        return None
    states = {point.elements.occluded for point in points}
    moist_alone = not stable and all(each.is_stable() for each in points if each.elements.occluded == min(states))
    # A moist finger that a force is out of reach of is looked at with the nearest: that is no level of the set-point.
    forces_n = [point.elements.force_n for point in points if point.elements.occluded == min(states)]
    beyond_n = [{each.force_n for each in missed(system, [state])} for state in sorted(states)]
    nowhere_n = tuple(sorted(set.intersection(*beyond_n)))
    band = Band(min(forces_n), max(forces_n), len(states) > 1, max(states), _bench(system), nowhere_n)
    known, rings_hz = peak if stable else None, ringing_hz(points)
    springs = isinstance(system.sensor, SuspendedSensor)
    if not isinstance(controller, PiController):
        return Ringing(stable, rings_hz, controller.kind, known, None, None, {}, band, (), (), springs, moist_alone)
    try:
        held = {path: _three_digits(gain) for path, gain in retune(points, HELD_PEAK).overrides.items()}
        there = elsewhere(system.evolve(held), {0.0: NEAR, OFF: NEAR})
        within = [each for each in there.places if each.how == "within"]
        not_held = tuple(str(each.condition) for each in there.places if each not in within)
        also = () if not_held or there.unseen else tuple(str(each.condition) for each in within)
    except FrictionloopError:
        held, not_held, also = {}, (), ()
    gains = controller.kp, controller.ki
    return Ringing(stable, rings_hz, "pi", known, *gains, held, band, not_held, also, springs, moist_alone)


def points_of(system: System) -> list[LinearLoop]:
    """Return the loops that are looked at: gains of a PI hold up to full occlusion, another law where it is designed.

    Raises
    ------
    FrictionloopError
        A loop that has no linear analysis.
    """
    from frictionloop.analysis import operating_band
    from frictionloop.design.corners import band_of
    from frictionloop.parameters import PiController

    plain = isinstance(system.controller, PiController)
    return operating_band(system, occluded=(0.0, 1.0)) if plain else band_of(system)


def _bench(system: System) -> str:
    from frictionloop.analysis.band import condition_of
    from frictionloop.parameters import SuspendedSensor

    sensor = system.sensor
    sprung = f", sensor resonance {sensor.resonance_hz:g} Hz" if isinstance(sensor, SuspendedSensor) else ""
    return f", {condition_of(system)}{sprung}"


def _three_digits(gain: float) -> float:
    """Return a gain with three digits, not above the one given."""
    if gain <= 0:
        return gain
    digit: float = 10.0 ** (math.floor(math.log10(gain)) - 2)
    return float(f"{math.floor(gain / digit) * digit:.3g}")


def as_json(found: Ringing | None) -> dict[str, Any] | None:
    """Return the same for a program."""
    return None if found is None else found._asdict() | {"band": found.band._asdict()}
