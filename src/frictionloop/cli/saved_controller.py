"""The comment lines of a saved controller: what it holds for, or what a check found of it."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from frictionloop.cli.controller_also import head_of, range_said
from frictionloop.cli.controller_holds import (
    also_said,
    ends_said,
    finger,
    fingers_proposed,
    has_people,
    many_said,
    out_of_reach,
    place_said,
    places_of,
    strokes_said,
    wanted_flags,
)
from frictionloop.cli.scores import between
from frictionloop.design.corners import CONTACT_S
from frictionloop.design.elsewhere import in_words

if TYPE_CHECKING:
    from frictionloop.cli.must_hold import MustHold
    from frictionloop.cli.other_fingers import OtherFingers
    from frictionloop.design.corners import Corner
    from frictionloop.design.wanted import Designed, Wanted
    from frictionloop.parameters import System

AGAIN = "Look again: frictionloop design check FILE"
"""Begins the line of a saved controller with the flags that it was designed for."""
NOT_SAVED = ("would hold", "other people", "other loads", "by the file")
"""Rows of a check that propose what to do next, which a file is not the place for."""
CONTACT_SAID = (
    f"A moist finger is one after {CONTACT_S:g} s on the plate, or after contact upon contact of motion.contact_s."
)


def holds(
    law: str, designed: Designed, after: System, wanted: Wanted, moist: str, crowd: Sequence[tuple[str, ...]] = ()
) -> list[str]:
    """Return the comment lines of a saved controller: for which strokes, forces and resonances it holds.

    ``after`` is the system with it, ``moist`` says how it is on a fully moist finger; empty of one that lifts.
    ``crowd`` are the rows of a verdict on other people's fingers, where these were looked at.
    """
    ranged = range_said(after, wanted)
    found = designed.corners
    forces = [each.loop.elements.force_n for each in found]
    states = sorted({each.loop.elements.occluded for each in found})
    fingers = " and ".join(finger(state) for state in states)
    limits = [
        f"{peak:.3g} " + (f"with it +-{100 * off:.3g} % off" if off else "as described")
        for off, peak in sorted(wanted.limits.items())
    ]
    return [
        f"Law {law} from frictionloop design controller. It holds for what follows; elsewhere, design again.",
        f"Strokes: {strokes_said(found, wanted) or 'none'}.",
        f"Forces: {between(min(forces), max(forces))}, {fingers}.",
        *([CONTACT_SAID] if max(states) > 0 else []),
        *instead_of(places_of(found), states),
        f"Resonance of the sensor: Ms up to {', '.join(limits)}.",
        *ends_said(wanted),
        *also_said(designed),
        *designed.warnings,
        *beyond_said(designed),
        *([f"Fully moist: {moist}."] if moist else []),
        *([f"Range: {ranged}."] if ranged else []),
        *(_fingers(crowd) if crowd else _other_fingers(found, wanted)),
        f"{AGAIN}{wanted_flags(found, wanted)}",
    ]


def _other_fingers(found: Sequence[Corner], wanted: Wanted) -> list[str]:
    """Return the line on the fingers that were not looked at."""
    many = fingers_proposed(wanted)
    said = f"The finger is that of this file; others: design with --fingers {many}, or that with the next line."
    return [said] if has_people(found[0].loop.system) else []


def _fingers(crowd: Sequence[tuple[str, ...]]) -> list[str]:
    """Return the lines on other people's fingers."""
    said = [f"{first}: {row}" if first else f"  {row}" for first, row in crowd if "`frictionloop" not in row]
    return [line for each in said for line in textwrap.wrap(each, 100, subsequent_indent="  ")]


def checked(verdict: Sequence[tuple[str, ...]], found: Sequence[Corner], wanted: Wanted, more: str) -> list[str]:
    """Return the comment lines of a controller that was checked: the rows of the verdict, and how to look again."""
    told, name = ["This controller as it was given; frictionloop design check found of it:"], ""
    for first, said in verdict:
        name = first or name
        if name not in NOT_SAVED and not said.startswith("`frictionloop"):
            told += textwrap.wrap(f"{first}: {said}" if first else f"  {said}", 100, subsequent_indent="  ")
    return [*told, f"{AGAIN}{wanted_flags(found, wanted)}{more}"]


def by_file(file: Path | None, must: MustHold, others: OtherFingers) -> str:
    """Return a line with the flags of what a saved controller says it was designed for that are not given here.

    Empty where all are, and of any other file. A value as usual counts as not given.
    """
    said = "" if file is None else next((each for each in head_of(file) if each.startswith(AGAIN)), "")
    flags = [each.strip() for each in re.split(r"(?:^|\s)--", said.removeprefix(AGAIN))[1:]]
    usual, own = vars(type(must)()) | vars(type(others)()), vars(must) | vars(others)
    given = [name for name in own if own[name] != usual[name]]
    left = [f"--{flag}" for flag in flags if flag.partition(" ")[0].replace("-", "_") not in given]
    if not left:
        return ""
    if not given:
        return f"`{' '.join(left)}` looks at what it was designed or checked for"
    return f"`{' '.join(left)}`, with which it was designed or checked, is left out here"


def beyond_said(designed: Designed) -> list[str]:
    """Return a line with the other slip lengths and speeds at which it is stable, beyond the limits; or none."""
    places = in_words(designed.elsewhere.where("beyond"))
    return [f"Stable, but beyond these limits: {'; '.join(places)}."] if places else []


def instead_of(systems: Sequence[System], states: Sequence[float]) -> list[str]:
    """Return a line for each force asked for that is out of reach: which was evaluated in its place."""
    said = [
        f"{each.in_words[0]} N is out of reach of {finger(each.occluded)}{place_said(systems, there)}: "
        f"{each.in_words[1]} N is evaluated in its place."
        for state in states
        for there, each in out_of_reach(systems, state)
    ]
    return [*said, *filter(None, [many_said(systems)])] if said else []
