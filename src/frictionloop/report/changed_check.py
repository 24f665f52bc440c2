"""Where the gains of a changed Fig. 5a hold, as ``design check`` says, on the finger and the forces that it draws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from frictionloop.loop.progress import Bar
from frictionloop.quantities import FrictionloopError
from frictionloop.report import protocol
from frictionloop.report.device import IDEAL, OPEN, fit, tracking
from frictionloop.report.numbers import number
from frictionloop.report.people import the_finger
from frictionloop.report.stability import Places, asked_for, checked
from frictionloop.report.stroke_numbers import Table

NO_BENCH = (OPEN, IDEAL)
"""Controllers that no bench has."""


class Check(NamedTuple):
    """What ``design check`` says."""

    places: dict[str, Places]
    """Of each pair of gains; empty where it can look at none."""
    said: list[str]
    """Which gains would hold at all places, with their error; or why none was looked at."""

    def as_dict(self) -> dict[str, Any]:
        """Return it by name, as JSON can hold it."""
        return {"places": {name: each._asdict() for name, each in self.places.items()}, "said": self.said}


def check(numbers: Table, changed: Mapping[str, Any], sines: protocol.Sines, bar: Bar) -> Check:
    """Return where each pair of gains holds on a bench, and what would hold everywhere.

    Parameters
    ----------
    numbers
        Those of the figure, by controller.
    changed
        What is changed of the bench, by dotted names.
    sines
        What the figure asks for.
    bar
        Says what goes on.
    """
    there, found = asked_for(changed, sines), dict[str, Places]()
    for each, row in numbers.items():
        if each in NO_BENCH:
            continue
        bar.doing(f"design check of the {each}")
        gains = {"controller.kp": row["kp"], "controller.ki": row["ki"]}
        try:
            found[each] = checked(there.evolve(gains))
        except FrictionloopError as error:  # no force is in reach
            return Check({}, [f"design check looks at no place: {error}"])
    return Check(found, _would_hold(found, changed, sines, bar) if found else [])


def best_of(found: Mapping[str, Places]) -> str:
    """Return the controller that holds at most places, and of these is unstable at fewest."""
    return max(found, key=lambda each: (found[each].held, -found[each].unstable))


def _would_hold(
    found: Mapping[str, Places], changed: Mapping[str, Any], sines: protocol.Sines, bar: Bar
) -> list[str]:  # fmt: skip
    """Return the gains that would hold at all places, in the ratio of the best, with the error that they leave."""
    name = best_of(found)
    instead = found[name].instead
    if not instead:
        return []
    bar.doing("Fig. 5a with gains that would hold everywhere")
    runs = tracking(protocol.finger_system(the_finger()).evolve(changed), instead, sines)
    kp, ki = (number(instead[f"controller.{each}"], 4) for each in ("kp", "ki"))
    return [f"kp {kp}, ki {ki} 1/s would hold at all of them: the error is {number(1e3 * fit(runs).rms_n)} mN then"]
