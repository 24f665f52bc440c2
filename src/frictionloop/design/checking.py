"""Does a controller that is there hold? The corners, slip lengths and speeds of a design, and what gains would hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from frictionloop.analysis.band import operating_band
from frictionloop.control.limit_observer import MOST_MARGIN
from frictionloop.design.corners import corners, occlusions, stroke_of
from frictionloop.design.elsewhere import Place, elsewhere, strokes_of
from frictionloop.design.held import CHECKED, ENDS, LOADS, SEARCHED, check_places
from frictionloop.design.least_gain import least_gain
from frictionloop.design.loop_gains import LoopGains, loop_gains
from frictionloop.design.over import Over
from frictionloop.design.plants import shifted
from frictionloop.design.wanted import Wanted
from frictionloop.loop.progress import step
from frictionloop.parameters import PiController, System
from frictionloop.parameters.filtered import FeedForward
from frictionloop.quantities import FrictionloopError

ROUNDING = 2e-3
"""Share of a factor on gains that is left for rounding these to four digits."""


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
    people: LoopGains | None = None
    """On how many other people it comes close to ringing; None without a finger."""

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
    A force out of reach counts as the nearest that can be had.

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
    asked = wanted or Wanted()
    check_places(system, asked)
    close = asked.over(CHECKED, LOADS)._replace(slip_lengths_um=())
    try:
        touched = Over(asked.slip_lengths_um).systems(system)
        own = [Place.of(corners(each, asked.limits, close, asked.lean)) for each in touched]
    except FrictionloopError as error:
        what = "its runs show what it does: frictionloop simulate, frictionloop sweep --fingers 100"
        raise FrictionloopError(f"{error}; {what}") from None
    more = elsewhere(system, asked.limits, asked.over(ENDS, LOADS), asked.lean, asked.slip_lengths_um)
    places = (*own, *more.places)
    gains = tuple(_least_gain(place) for place in places)
    people = loop_gains(system, asked.over(ENDS, LOADS))
    found = Checked(system.controller.kind, places, more.unseen, gains, {}, _notes(system), len(own), people)
    return found if found.holds else found._replace(instead=_instead(system, found))


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
    if controller.kind == "lookup":
        return (
            "no loop: this law does not use the force that is measured, so it cannot ring, and lowers no disturbance",
        )
    return ()


def _instead(system: System, checked: Checked) -> Mapping[str, float]:
    """Return gains, or a margin, with which all corners hold."""
    controller: Any = system.controller
    gain = min(checked.gains)
    if isinstance(controller, PiController | FeedForward):  # G is linear in kp and ki, both together
        less = {f"controller.{name}": rounded(gain * getattr(controller, name)) for name in ("kp", "ki")}
        return less if any(less.values()) else {}
    if controller.kind == "limit_observer" and gain > 0.0:  # and with the inverse of its margin
        margin = controller.susceptibility_margin / rounded(gain)
        return {"controller.susceptibility_margin": float(f"{margin:.4g}")} if margin <= MOST_MARGIN else {}
    return {}
