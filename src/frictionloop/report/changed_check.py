"""Where the gains of a changed Fig. 5a hold, as ``design check`` says, on the finger and the forces that it draws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from frictionloop.loop.progress import Bar
from frictionloop.quantities import FrictionloopError
from frictionloop.report import protocol
from frictionloop.report.device import IDEAL, OPEN
from frictionloop.report.stability import Places, asked_for, checked, integral_alone
from frictionloop.report.stroke_numbers import Table

NO_BENCH = (OPEN, IDEAL)
"""Controllers that no bench has."""


class Check(NamedTuple):
    """What ``design check`` says."""

    places: dict[str, Places]
    """Of each pair of gains; empty where it can look at none."""
    said: list[str]
    """Why none was looked at."""
    instead: Mapping[str, float]
    """An integral alone that holds at all places, as overrides; empty if a pair does, or there is none."""

    def as_dict(self) -> dict[str, Any]:
        """Return it by name, as JSON can hold it."""
        return {
            "places": {name: each._asdict() for name, each in self.places.items()},
            "said": self.said,
            "instead": dict(self.instead),
        }

    @property
    def best(self) -> str:
        """The controller that holds at most places, and of these is unstable at fewest."""
        return max(self.places, key=lambda each: (self.places[each].held, -self.places[each].unstable))


def check(numbers: Table, changed: Mapping[str, Any], sines: protocol.Sines, bar: Bar) -> Check:
    """Return where each pair of gains holds on a bench.

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
            return Check({}, [f"design check looks at no place: {error}"], {})
    if not found or any(each.held == each.places for each in found.values()):
        return Check(found, [], {})
    bar.doing("an integral alone that holds everywhere")
    return Check(found, [], integral_alone(there))
