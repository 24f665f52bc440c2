"""What comes first of a designed controller: where it is stable, where it is not, and the command to go on with."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from frictionloop.cli.controller_also import moist_row, noisy, range_said
from frictionloop.cli.controller_holds import (
    also_said,
    beyond_reach,
    finger,
    fingers_proposed,
    has_people,
    lengths_of,
    other_people,
    places_of,
    strokes_said,
)
from frictionloop.cli.other_fingers import LOWERED
from frictionloop.cli.scores import between
from frictionloop.design.elsewhere import in_words
from frictionloop.firmware.board_fit import misfits_of_gains
from frictionloop.parameters import Strokes

if TYPE_CHECKING:
    from frictionloop.design.corners import Corner
    from frictionloop.design.elsewhere import How, Place
    from frictionloop.design.wanted import Designed, Wanted
    from frictionloop.parameters import System

Row = tuple[str, ...]
NOT_THERE = "Do not use it there: it was not designed for it."
BOTH = " `--slip-lengths-um {:g},{:g}` designs for these lengths."
ONE = "No controller of this law holds at every slip length, so this one is for one alone. {}."
FASTER = " If fingers stroke so, `--speeds {:g},{:g}` designs for it; slower and faster ones are looked at too."
MORE = "`--fingers {}` with this command {} so many random fingers too"
LESS = " `frictionloop design check` says how much less gain would hold there."
NOT_HELD: tuple[tuple[str, How], ...] = (
    ("UNSTABLE", "unstable"), ("CLOSE TO UNSTABLE", "near"), ("BEYOND LIMITS", "beyond")
)  # fmt: skip
SLOWER = 0.5
"""Speed over that of the strokes from which a range is proposed: a finger that strokes passes every slower one."""

LIGHTER, HEAVIER = 0.7, 1.4
"""Loads over that of the strokes between which a range is proposed: nobody presses evenly (chosen)."""


def verdict(
    designed: Designed,
    after: System,
    wanted: Wanted,
    out: Path | None,
    moist: str = "",
    people: Sequence[Row] = (),
) -> list[Row]:
    """Return rows of the verdict: within its limits where, how else elsewhere, and what to do next.

    ``moist`` says how it is on a fully moist finger (`fully_moist`), ``people`` are rows on other people's fingers,
    where these were looked at.
    """
    found, elsewhere = designed.corners, designed.elsewhere
    forces = [each.loop.elements.force_n for each in found]
    states = sorted({each.loop.elements.occluded for each in found})
    where = [
        strokes_said(found, wanted),
        between(min(forces), max(forces)),
        " and ".join(map(finger, states)),
    ]
    farthest = max(abs(each.off) for each in found)
    where += [f"sensor's resonance up to {100 * farthest:.3g} % off"] if farthest else []
    worse: list[Row] = [*beyond_reach(places_of(found), states)]
    for name, how in NOT_HELD:
        worse += [(name if k == 0 else "", place) for k, place in enumerate(in_words(elsewhere.where(how)))]
    if not_held := [each for each in elsewhere.places if each.how != "within"]:
        hints = _designs_for(not_held, found, bool(designed.one_length))
        not_there = NOT_THERE if any(each.how != "beyond" for each in not_held) else ""
        worse += [("", (not_there + hints + LESS).lstrip())]
    does = "lowers the gains until the limits hold on" if after.controller.kind in LOWERED else "looks at"
    others = other_people(designed.people, after.controller.kind, MORE.format(fingers_proposed(wanted), does))
    worse += people
    rows: list[Row] = [("HOLDS", but(worse, moist) + "; ".join(filter(None, where)))]
    rows += [("firmware" if k == 0 else "", said) for k, said in enumerate(misfits_of_gains(after))] if out else []
    rows += [] if people else others
    rows += [("one length", ONE.format(designed.one_length))] if designed.one_length else []
    rows += [*worse, *(("also holds", each) for each in also_said(designed))]
    rows += moist_row(after, wanted, moist, bool(people))
    rows += [("noisy", said)] if (said := noisy(after)) else []
    rows += [("range", said)] if (said := range_said(after, wanted)) else []
    return [*rows, *_others(after, wanted), *_next(after, wanted, out)]


def but(worse: Sequence[Row], moist: str = "") -> str:
    """Return what of a verdict's rows does not do, for its first line; nothing where all does."""
    names = [row[0] for row in worse if row[0].isupper()]
    apart, last = [k for k, name in enumerate(names) if name in dict(NOT_HELD)], names[-1:]
    if apart:
        names[apart[0]] = f"elsewhere {names[apart[0]]}"
    fully = [how for how in ("CLOSE TO UNSTABLE", "UNSTABLE") if how in moist][:1]
    names += ["when fully moist too"] if fully == last != [] else [f"{how} when fully moist" for how in fully]
    return f"but {', '.join(names)}; rows below. Where it holds: " if names else ""


def _designs_for(places: Sequence[Place], found: Sequence[Corner], in_vain: bool) -> str:
    """Return which flags design for places that do not hold; nothing for a law that is held there already.

    ``in_vain`` says that the whole range was tried.
    """
    here = set(lengths_of(found))
    missing = {each.slip_length_um for each in places if each.slip_length_um is not None} - here
    ends = min(here | missing, default=0.0), max(here | missing, default=0.0)
    hints = BOTH.format(*ends) if missing and len(here) == 1 and not in_vain else ""
    own = [each.loop.system.motion.speed_mm_s for each in found if isinstance(each.loop.system.motion, Strokes)]
    speeds = [speed for each in places if each.slip_length_um not in missing for speed in each.speeds_mm_s]
    others = [speed for speed in speeds if not min(own) <= speed <= max(own)] if own else []
    return hints + (FASTER.format(min(*others, *own), max(*others, *own)) if others else "")


def _others(system: System, wanted: Wanted) -> list[Row]:
    """Return the flags that design for a range of speeds or loads, where one alone was looked at."""
    if not isinstance(system.motion, Strokes):
        return []
    speed, load_n = system.motion.speed_mm_s, system.motion.load_n
    flags = {
        "speeds": f"`--speeds {SLOWER * speed:g},{speed:g}`" * (not wanted.speeds_mm_s),
        "loads": f"`--loads {LIGHTER * load_n:.2g},{HEAVIER * load_n:.2g}`" * (not wanted.loads_n),
    }
    left = {name: flag for name, flag in flags.items() if flag}
    if not left:
        return []
    said = f"for other {' and '.join(left)}, {' and '.join(left.values())} design between these ends, in some minutes"
    return [("wider", said)]


def _next(system: System, wanted: Wanted, out: Path | None) -> list[Row]:
    """Return the command to go on with, and at which speed it simulates; with several, that for the others too."""
    if out is None:
        return [("go on with", "this command and `--out my-controller.toml`, which saves the controller")]
    file = shlex.quote(str(out))
    said = f"frictionloop simulate {file} --plot run.svg"
    simulated = [("", each) for each in speeds_said(system, wanted, file)]
    return [("go on with", said), *simulated]


def speeds_said(system: System, wanted: Wanted, file: str) -> list[str]:
    """Return the speed that the saved system is simulated at, and the commands for other speeds and other people."""
    if not isinstance(system.motion, Strokes):
        return []
    said = [f"A simulation runs at {system.motion.speed_mm_s:g} mm/s, `motion.speed_mm_s` in the file."]
    if wanted.speeds_mm_s:
        values = ",".join(f"{each:.3g}" for each in wanted.spread_mm_s(3))
        lifts = ", which keeps the time of contacts and path of the file at each" * (system.motion.contact_s > 0.0)
        said.append(f"For the others: frictionloop sweep {file} --over motion.speed_mm_s={values}{lifts}")
    if has_people(system):
        loads = f" --loads {','.join(f'{each:g}' for each in wanted.loads_n)}" * bool(wanted.loads_n)
        said.append(
            f"For how many people, and how well: frictionloop sweep {file} --fingers 100 --fingers-seed 1{loads}"
        )
    return said
