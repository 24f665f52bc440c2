"""Other people's fingers on which a controller is looked at, as flags that a design and a check share."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags
from frictionloop.cli.must_hold import ASKED

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.design.corners import Corner
    from frictionloop.design.for_fingers import ForFingers
    from frictionloop.design.wanted import Wanted
    from frictionloop.parameters import System

Row = tuple[str, ...]
LOWERED = ("pi", "notch_pi")
"""Laws whose gains a design lowers."""
MOST_FINGERS = 100_000
"""More than a population needs for the worst of a thousand, at some 0.1 s each."""


def _asked(said: str) -> Parameter:
    return Parameter(group=ASKED, help=said)


@Parameter(name="*")
@dataclass(frozen=True)
class OtherFingers:
    """How many fingers of a population are looked at besides that of the system."""

    fingers: Annotated[
        flags.Whole | None,
        _asked(
            "So many random fingers besides, each with its own friction, skin and load. ``design controller`` lowers "
            "PI gains until the limits hold on all of them, ``design check`` counts those on which they hold. With "
            "--loads each is pressed with both ends of them."
        ),
    ] = None
    fingers_seed: Annotated[flags.Whole | None, _asked("Seed of the fingers; 0 if not given.")] = None
    population: Annotated[
        Path | None,
        _asked(
            "Draw the fingers from this measured population (.toml, from ``identify bench --population``) in place of "
            "the assumed one."
        ),
    ] = None

    def check(self) -> None:
        """Refuse a number or a seed out of range, and what says where fingers come from without any."""
        checks.check_fingers(self.fingers, self.fingers_seed, MOST_FINGERS, population=self.population)

    def people(self, system: System, overrides: list[str] | None) -> Sequence[Any] | None:
        """Return the fingers; None if none are asked for."""
        from frictionloop.cli.population import population_of

        if not self.fingers:
            return None
        return population_of(system, self.fingers, self.fingers_seed or 0, overrides, self.population)

    def takes(self, law: str, system: System, wanted: Wanted, designs: bool = False) -> str:
        """Return what looking at them adds to a forecast, with the look at gains that a design lowers for them."""
        from frictionloop.cli.check_text import EACH_S, FINGERS_S, OTHER_FINGERS_S, OTHER_S, takes
        from frictionloop.design.checking import loops, loops_of_a_finger

        if not self.fingers:
            return ""
        count = self.fingers * loops_of_a_finger(system, wanted)
        lasts = takes(count, FINGERS_S.get(law, OTHER_FINGERS_S))
        again = takes(loops(system, wanted), EACH_S.get(law, OTHER_S))
        more = f", and {again} to check the gains for them" * (designs and law in LOWERED)
        return f", then {lasts} for {self.fingers} fingers{more}"

    def look(self, system: System, people: Sequence[Any] | None, wanted: Wanted) -> xr.Dataset | None:
        """Return what is found on them, after Ctrl-C on those that were looked at; None if none are asked for."""
        from frictionloop.cli import screen
        from frictionloop.design.on_fingers import FingersInterrupted, check_fingers

        if people is None:
            return None
        try:
            return check_fingers(system, people, wanted)
        except FingersInterrupted as stop:
            seen = stop.partial.sizes["finger"]
            screen.note(f"stopped after {seen} of {len(people)} fingers, and goes on with these; Ctrl-C again ends it")
            screen.tell_notes()
            return stop.partial

    def stop(self, found: xr.Dataset | None) -> None:
        """Leave as after Ctrl-C if not all that were asked for were looked at."""
        if found is not None and found.sizes["finger"] < (self.fingers or 0):
            raise KeyboardInterrupt(f"{found.sizes['finger']} of {self.fingers} fingers looked at")

    def rows(
        self,
        found: xr.Dataset | None,
        system: System,
        wanted: Wanted,
        asked: Sequence[Corner],
        lowered: ForFingers | None = None,
        given: str = "FILE",
    ) -> list[Row]:
        """Return rows of a verdict on them, who were looked at as ``asked``; none if none were asked for.

        ``system`` has the gains that they were looked at with, ``lowered`` says what a design made of these, ``given``
        names the system on another command line.
        """
        from frictionloop.cli import check_fingers, controller_holds

        if found is None:
            return []
        first = f"the first {found.sizes['finger']} of " * (found.sizes["finger"] < (self.fingers or 0))
        drawn = f"{first}seed {self.fingers_seed or 0}" + (f" of {self.population}" if self.population else "")
        own = "each has its own friction and skin" + ", and load" * (not wanted.loads_n)
        moistest = max((each.loop.elements.occluded for each in asked), default=0.0)
        moist = f", none more than {moistest:.0%} occluded" if 0 < round(100 * moistest) < 100 else ""
        where = f"{controller_holds.strokes_said(asked, wanted)}{moist}; {own}"
        again = controller_holds.wanted_flags(asked, wanted)
        other = replace(self, fingers_seed=(self.fingers_seed or 0) + 1)  # gains that hold on some are tried on others
        if lowered and lowered.factor < 1.0:
            many = replace(other, fingers=check_fingers.MANY).again()
            rows = check_fingers.lowered_rows(found, system, lowered.factor, drawn, where, again + many)
            return [*rows, *_own_loads(system, wanted)]
        rows = check_fingers.rows(found, system, drawn, where, given + again + other.again())
        return [*rows, *check_fingers.not_lowered(lowered)]

    def again(self) -> str:
        """Return the flags that look at the same fingers again, with a blank before each; empty without any."""
        given = {"fingers": self.fingers, "fingers-seed": self.fingers_seed, "population": self.population}
        return "".join(f" --{name} {shlex.quote(str(value))}" for name, value in given.items() if value is not None)

    def as_json(self, found: xr.Dataset | None, lowered: ForFingers | None = None) -> dict[str, Any]:
        """Return what was found by name; nothing if none were asked for."""
        from frictionloop.cli import check_fingers

        if found is None:
            return {}
        there = check_fingers.as_json(found, self.fingers_seed or 0)
        if lowered is None:
            return {"fingers": there}
        # What was found is of the gains before they were lowered: the design's other values are of those after.
        after = {"gains_lowered_to": lowered.factor, "not_lowered": lowered.wanting, "ki_for_all": lowered.least_ki}
        return {"fingers": after | {"before_lowering": there}}


def _own_loads(system: System, wanted: Wanted) -> list[Row]:
    """Return a row on the loads of the fingers, which differ from that of the file, where no range is asked for."""
    from frictionloop.cli.controller_verdict import HEAVIER, LIGHTER
    from frictionloop.parameters import Strokes

    if wanted.loads_n or not isinstance(system.motion, Strokes):
        return []
    low, high = (factor * system.motion.load_n for factor in (LIGHTER, HEAVIER))
    own = f"each presses with its own load, the finger of the file with {system.motion.load_n:g} N"
    range_n = f"`--loads {low:.2g},{high:.2g}` in this command looks at them between these"
    return [("", f"{own}; where people are to press so, {range_n}")]
