"""Does a controller that is there hold? The corners, slip lengths and speeds of a design, and what gains would hold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from frictionloop.analysis.band import operating_band
from frictionloop.analysis.law_space import law_space
from frictionloop.analysis.state_space import StateSpace, close
from frictionloop.design.corners import Corner, corners, occlusions, stroke_of
from frictionloop.design.elsewhere import Place, elsewhere, strokes_of
from frictionloop.design.held import CHECKED, ENDS, LOADS, SEARCHED, check_places
from frictionloop.design.least_gain import least_gain
from frictionloop.design.limit_linear import compliance_of, largest_gain, learnt
from frictionloop.design.observed import GUARD, LOWEST_HZ
from frictionloop.design.over import Over
from frictionloop.design.plants import Plants, shifted
from frictionloop.design.synthesis import SMALL_SIGNALS
from frictionloop.design.wanted import Wanted
from frictionloop.loop.progress import step
from frictionloop.parameters import PiController, System
from frictionloop.parameters.filtered import FeedForward
from frictionloop.quantities import FrictionloopError

ROUNDING = 2e-3
"""Share of a factor on gains that is left for rounding these to four digits."""
HALVINGS = 8
"""Of the ratio between the bandwidth that is there and the lowest: to within a few percent."""
ALIKE = 1e-6
"""Share by which the matrices of two laws may differ and be one."""


class Checked(NamedTuple):
    """A controller as it was found."""

    law: str
    places: tuple[Place, ...]
    """Slip lengths and speeds, those asked for first."""
    unseen: tuple[str, ...]
    """Those that cannot be looked at, in words with the reason."""
    gains: tuple[float, ...]
    """Factor on the loop gain up to which, with every smaller one, the limits hold, for each place."""
    instead: Mapping[str, float]
    """Overrides with which they hold at all places; empty where they do already, or none was found."""
    notes: tuple[str, ...] = ()
    """What else a person should know."""
    asked: int = 0
    """How many of the places, the first ones, are those that were asked for."""

    @property
    def holds_as_asked(self) -> bool:
        """Whether the limits hold at the places that were asked for."""
        return all(place.how == "within" for place in self.places[: self.asked])

    @property
    def holds(self) -> bool:
        """Whether the limits hold at all places."""
        return all(place.how == "within" for place in self.places)


def check_controller(system: System, wanted: Wanted | None = None) -> Checked:
    """Return how the controller of a System does, without a search for another one.

    It is looked at as a new design is: at lowest, mean and highest force, on a dry and a moist finger, with the
    resonance off, at the slip lengths, speeds and loads that are asked for; then at half and four times the speed.
    A force out of reach counts as the nearest that can be had. Of a `limit_observer` the loop gain is 20 % above that
    of a finger whose susceptibility it knows.

    Parameters
    ----------
    system
        The bench with its controller, of any law that has a linear analysis.
    wanted
        What must hold. None: `Wanted` as it is.

    Raises
    ------
    FrictionloopError
        No force asked for is in reach of a finger just landed, or the law has no linear analysis: the line says what
        to do.
    """
    asked, judged = wanted or Wanted(), learnt(system)
    check_places(system, asked)
    close = asked.over(CHECKED, LOADS)._replace(slip_lengths_um=())
    try:
        touched = Over(asked.slip_lengths_um).systems(judged)
        own = [Place.of(corners(each, asked.limits, close, asked.lean)) for each in touched]
    except FrictionloopError as error:
        what = "its runs show what it does: frictionloop simulate, frictionloop sweep --fingers 100"
        raise FrictionloopError(f"{error}; {what}") from None
    more = elsewhere(judged, asked.limits, asked.over(ENDS, LOADS), asked.lean, asked.slip_lengths_um)
    places = (*own, *more.places)
    gains = tuple(_least_gain(place) for place in places)
    found = Checked(system.controller.kind, places, more.unseen, gains, {}, _notes(system), len(own))
    return found if found.holds else found._replace(instead=_instead(judged, found))


def rounded(gain: float) -> float:
    """Return the largest gain that holds with four digits, rounded so that it holds."""
    return float(f"{(1.0 - ROUNDING) * gain:.4g}")


def _least_gain(place: Place) -> float:
    step(f"what gain would hold{stroke_of(place.corners[0].loop.system)}")
    return least_gain([each.loop for each in place.corners], [each.limit for each in place.corners])


def loops(system: System, wanted: Wanted) -> int:
    """Return at how many loops a check looks, at most: it says how long it takes."""
    close, few = wanted.over(CHECKED, LOADS), wanted.over(ENDS, LOADS)
    strokes, loads = strokes_of(system, few.speeds_mm_s, wanted.slip_lengths_um), max(1, len(few.loads_n))
    return (len(close.systems(system)) + loads * len(strokes)) * _loops_of_a_place(system, wanted)


def loops_of_a_finger(system: System, wanted: Wanted) -> int:
    """Return at how many loops `check_fingers` looks for each finger, at most."""
    return len(wanted.over(SEARCHED, ENDS).systems(system)) * _loops_of_a_place(system, wanted)


def _loops_of_a_place(system: System, wanted: Wanted) -> int:
    band = operating_band(system.evolve({"controller.kind": "pi"}), occluded=occlusions(system))
    return wanted.lean.loops_each * len(shifted(band, wanted.limits))


def _notes(system: System) -> tuple[str, ...]:
    controller: Any = system.controller
    if controller.kind == "super_twisting":
        return (SMALL_SIGNALS,)
    if controller.kind == "lookup":
        return (
            "no loop: this law does not use the force that is measured, so it cannot ring, and lowers no disturbance",
        )
    if controller.kind == "limit_observer":
        return (
            f"this law is told its contact, controller.compliance_um_per_n = {controller.compliance_um_per_n:g}; on "
            f"that of this system {compliance_of(system):g} is true. The loop gain is {largest_gain(system) - 1:.0%} "
            "above that of a finger whose susceptibility is known",
        )
    return ()


def _instead(system: System, checked: Checked) -> Mapping[str, float]:
    """Return gains, or a bandwidth, with which all corners hold."""
    controller: Any = system.controller
    found, gain = [corner for place in checked.places for corner in place.corners], min(checked.gains)
    if isinstance(controller, PiController | FeedForward):  # G is linear in kp and ki, both together
        less = {f"controller.{name}": rounded(gain * getattr(controller, name)) for name in ("kp", "ki")}
        return less if any(less.values()) else {}
    if hasattr(controller, "bandwidth_hz") and _one_law([corner.loop.law for corner in found]):
        return _slower(system, found)
    return {}


def _slower(system: System, found: Sequence[Corner]) -> Mapping[str, float]:
    """Return a lower bandwidth with which an observer holds, whose law is the same at every corner."""
    controller: Any = system.controller
    loops, limits = [corner.loop for corner in found], np.array([corner.limit for corner in found])
    plants, spaces = Plants.of(loops), [loop.plant.state_space() for loop in loops]

    def held(bandwidth_hz: float) -> bool:
        there = loops[0].system.evolve({"controller.bandwidth_hz": bandwidth_hz})
        law = law_space(there, loops[0].elements, loops[0].plant)
        near = 1.0 / plants.distances(-law.response(plants.frequency_hz)[:, 1, 1]) > GUARD * limits
        return not np.any(near) and all(close(space, law).is_stable() for space in spaces)

    low, high = LOWEST_HZ, float(controller.bandwidth_hz)
    if not (low < high and held(low)):
        return {}
    for _ in range(HALVINGS):
        middle = float(f"{math.sqrt(low * high):.3g}")
        low, high = (middle, high) if held(middle) else (low, middle)
    return {"controller.bandwidth_hz": low}


def _one_law(laws: Sequence[StateSpace]) -> bool:
    first = laws[0]
    return all(
        mine.shape == other.shape and np.allclose(mine, other, rtol=ALIKE, atol=ALIKE * np.max(np.abs(mine), initial=0))
        for law in laws[1:]
        for mine, other in ((first.A, law.A), (first.B, law.B), (first.C, law.C), (first.D, law.D))
    )
