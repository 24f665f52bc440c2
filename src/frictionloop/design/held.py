"""One synthesis held over ranges of speeds and loads, and the forces that it is held at."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import count

from frictionloop.analysis.operating import check_reach
from frictionloop.design.corners import Corner, broken, corners
from frictionloop.design.least_gain import least_gain
from frictionloop.design.over import Over
from frictionloop.design.requirements import Designed, Requirements, unheld
from frictionloop.loop.progress import step
from frictionloop.parameters import Strokes, System

SEARCHED, CHECKED = 3, 9
"""Speeds in a range that a search begins with, and at which its result is looked at."""
ENDS, LOADS = 2, 3
"""The same of loads: the loop's gain goes with the load, so its ends are the worst of most laws."""
LOWERED = 0.95
"""Least factor on the gains of a search whose grid of frequencies missed a peak (chosen); with less, the law fails."""
GAINS = ("controller.kp", "controller.ki")
Synthesis = Callable[[System, Requirements], Designed]


def check_places(system: System, asked: Requirements) -> None:
    """Refuse a speed or a load at which none of the forces can be had; one alone counts as the nearest that can."""
    _, speeds, loads = asked.over(ENDS, LOADS)
    for there in Over((), speeds, loads).systems(system):
        check_reach(there)


def held_between(
    system: System, law: str, synthesis: Synthesis, asked: Requirements
) -> tuple[Designed, Sequence[Corner]]:
    """Return a controller, and its corners at closely spaced speeds and loads, all within the limits.

    The search sees few of them; one at which its result does not hold joins them, and it is made again.

    Raises
    ------
    FrictionloopError
        It does not hold where it was searched for: the line says where, and what limits.
    """
    _, speeds, loads = asked.over(SEARCHED, ENDS)
    searched, close = replace(asked, speeds_mm_s=speeds, loads_n=loads), asked.over(CHECKED, LOADS)
    searches = count(1)
    while True:
        step(f"search {next(searches)}")
        found = _short(synthesis(system, searched))
        at = found.corners or corners(system.evolve(found.overrides), asked.limits, close, asked.lean)
        worst = broken(at)
        if worst is None:
            return found, at
        more = _joined(searched, worst.loop.system)
        if more != searched:
            searched = more
            continue
        factor = least_gain([each.loop for each in at], [each.limit for each in at])
        lower = lowered(found, factor) if factor >= LOWERED else None
        again = corners(system.evolve(lower.overrides), asked.limits, close, asked.lean) if lower else at
        if lower is None or broken(again):
            raise unheld(law, asked, worst)
        return lower, again


def _joined(searched: Requirements, there: System) -> Requirements:
    """Return what is searched for with the speed and the load of a system among those that are."""
    if not isinstance(there.motion, Strokes):
        return searched
    speeds, loads = searched.speeds_mm_s, searched.loads_n
    if speeds and there.motion.speed_mm_s not in speeds:
        speeds = (*speeds, there.motion.speed_mm_s)
    if loads and there.motion.load_n not in loads:
        loads = (*loads, there.motion.load_n)
    return replace(searched, speeds_mm_s=speeds, loads_n=loads)


def lowered(found: Designed, factor: float) -> Designed | None:
    """Return PI gains times a factor, not looked at; None of a law without them."""
    if not set(GAINS) <= set(found.overrides):
        return None
    lower = {path: factor * found.overrides[path] for path in GAINS}
    return _short(found._replace(overrides={**found.overrides, **lower}, corners=()))


def _short(found: Designed) -> Designed:
    """Return a controller with numbers of five digits, before it is looked at; as it is where that was done already."""
    if found.corners:
        return found
    values = {path: float(f"{value:.5g}") if isinstance(value, float) else value
              for path, value in found.overrides.items()}  # fmt: skip
    return found._replace(overrides=values)
