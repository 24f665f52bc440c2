"""What comes first of a designed controller: where it is stable, where it is not, and the command to go on with."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from frictionloop.cli.controller_also import fully_moist, range_said
from frictionloop.cli.controller_holds import also_said, beyond_reach, finger, strokes_said
from frictionloop.cli.scores import between
from frictionloop.design.elsewhere import in_words
from frictionloop.parameters import Strokes

if TYPE_CHECKING:
    from frictionloop.design.wanted import Designed, Wanted
    from frictionloop.parameters import System

Row = tuple[str, ...]
NOT_THERE = "Do not use it there: it was not designed for it."
BOTH = " `--law hinf` designs for both contacts, if the sensor's noise lets it."
LESS = " `frictionloop design check` says how much less gain would hold there."
SLOWER = 0.5
"""Speed over that of the strokes from which a range is proposed: a finger that strokes passes every slower one."""


def verdict(designed: Designed, after: System, wanted: Wanted, out: Path | None) -> list[Row]:
    """Return rows of the verdict: stable where, how else elsewhere, and what to do next."""
    found, elsewhere = designed.corners, designed.elsewhere
    forces = [each.loop.elements.force_n for each in found]
    states = sorted({each.loop.elements.occluded for each in found})
    where = [each.removeprefix(", ") for each in strokes_said(found, wanted)]
    where += [between(min(forces), max(forces)), " and ".join(map(finger, states))]
    farthest = max(abs(each.off) for each in found)
    where += [f"sensor's resonance up to {100 * farthest:.3g} % off"] if farthest else []
    rows: list[Row] = [("STABLE", "; ".join(filter(None, where)))]
    rows += beyond_reach(found[0].loop.system, states)
    rows += [("", each) for each in also_said(designed)]
    checked = len(rows)
    for name, places in (("UNSTABLE", elsewhere.where("unstable")), ("CLOSE TO UNSTABLE", elsewhere.where("near"))):
        rows += [(name if k == 0 else "", place) for k, place in enumerate(in_words(places))]
    contacts = {getattr(each.loop.system.finger, "contact", "") for each in found}
    rows += [("", NOT_THERE + BOTH * (len(contacts) == 1) + LESS)] if len(rows) > checked else []
    rows += [("fully moist", said)] if (said := fully_moist(after, wanted)) else []
    rows += [("range", said)] if (said := range_said(after)) else []
    return [*rows, *_other_speeds(after, wanted), *_next(after, wanted, out)]


def _other_speeds(system: System, wanted: Wanted) -> list[Row]:
    if wanted.speeds_mm_s or not isinstance(system.motion, Strokes):
        return []
    speed = system.motion.speed_mm_s
    said = f"`--speeds {SLOWER * speed:g},{speed:g}` holds it from one to the other; it takes up to five minutes"
    return [("other speeds", said)]


def _next(system: System, wanted: Wanted, out: Path | None) -> list[Row]:
    """Return the command to go on with, and at which speed it simulates; with several, that for the others too."""
    if out is None:
        return [("go on with", "this command and `--out my-controller.toml`, which saves the controller")]
    file = shlex.quote(str(out))
    said = f"frictionloop simulate {file} --plot run.svg"
    return [("go on with", said), *(("", each) for each in speeds_said(system, wanted, file))]


def speeds_said(system: System, wanted: Wanted, file: str) -> list[str]:
    """Return the speed that the saved system is simulated at, and the command for others that it was designed for."""
    if not isinstance(system.motion, Strokes):
        return []
    said = [f"A simulation runs at {system.motion.speed_mm_s:g} mm/s, `motion.speed_mm_s` in the file."]
    if wanted.speeds_mm_s:
        values = ",".join(f"{each:.3g}" for each in wanted.spread_mm_s(3))
        said.append(f"For the others: frictionloop sweep {file} --over motion.speed_mm_s={values}")
    return said
