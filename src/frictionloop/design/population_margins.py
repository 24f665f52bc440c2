"""One controller on many fingers: how far each is from its limits, at the corners that a design is checked at."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.operating import force_band, missed, occlusions
from frictionloop.design.corners import MET, cases_of, rough_corners, worst_corner
from frictionloop.design.plants import least_gain
from frictionloop.design.requirements import SEARCHED, Requirements
from frictionloop.findings import Condition, Finding
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import System
from frictionloop.physics.reach import ROUNDING
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.brief import Brief


class FingersInterrupted(KeyboardInterrupt, metaclass=Brief):
    """Ctrl-C while fingers are looked at; ``partial`` has those that were looked at before."""

    def __init__(self, partial: xr.Dataset) -> None:
        super().__init__(f"{partial.sizes['finger']} fingers looked at")
        self.partial = partial


ABOUT = {
    "sensitivity_peak": ("1", "Ms farthest beyond its limit"),
    "limit": ("1", "largest Ms there"),
    "gain_factor": ("1", "gain factor that still holds"),
    "slip_length_um": ("um", "slip length there"),
    "speed_mm_s": ("mm/s", "speed there"),
    "load_n": ("N", "mean load there"),
    "force_n": ("N", "friction force there"),
    "occluded": ("1", "occlusion there"),
    "resonance_off": ("1", "resonance off there"),
    "in_reach": ("", "all forces in reach"),
    "unseen": ("", "why not looked at"),
}
"""Variables of `check_fingers`, with units and meaning."""


def check_fingers(
    system: System,
    people: Sequence[Mapping[str, Any]],
    wanted: Requirements | None = None,
    *,
    progress: bool | None = None,
) -> xr.Dataset:
    """Return how near the loop of each finger of a population comes to instability, with one controller for all.

    Each finger is looked at as `check` looks at that of the system: at lowest, mean and highest force, just
    landed and moist, with the resonance off, at the slip lengths and speeds that are asked for, from slip length 0 to
    its own if none is. It is pressed with its own load, or with the ends of the loads that are asked for. What the
    controller believes stays as it is. Where none of the forces can be had, on a moist finger say, the command stays
    at its limit, and nothing is looked at.

    Parameters
    ----------
    system
        The bench with its controller, of any law that has a linear analysis.
    people
        Overrides, one finger each, as of `fingers`.
    wanted
        What must hold. None: `Requirements` as it is.
    progress
        Show a progress bar; None: on a terminal.

    Returns
    -------
    xarray.Dataset
        Over ``finger``: ``holds``, ``stable`` and the variables of `ABOUT`, those of the corner farthest beyond its
        limit. A finger that cannot be looked at has NaN, holds nowhere, and ``unseen`` says why.

    Raises
    ------
    FrictionloopError
        No finger, or a law that has no linear analysis: the reason is that of the first finger.
    FingersInterrupted
        On Ctrl-C once a finger has been looked at, carrying what was found.
    """
    must = wanted or Requirements()
    if not len(people):
        raise FrictionloopError("people: needs one at least")
    found: list[dict[str, Any]] = []
    with progress_bar("margins of fingers", len(people), progress) as bar:
        try:
            for person in people:
                try:
                    found.append(_of(system.evolve(dict(person)), must))
                except FrictionloopError as error:
                    found.append({"unseen": str(error)})
                bar()
        except KeyboardInterrupt:
            if all("unseen" in each for each in found):
                raise
            raise FingersInterrupted(_dataset(found)) from None
    if all("unseen" in each for each in found):
        raise FrictionloopError(f"people: none can be looked at: {found[0]['unseen']}")
    return _dataset(found)


def _dataset(found: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    missing = {"in_reach": True, "unseen": ""}
    values = {name: ("finger", np.array([each.get(name, missing.get(name, math.nan)) for each in found]),
                     {"units": units, "long_name": said}) for name, (units, said) in ABOUT.items()}  # fmt: skip
    result = xr.Dataset(values, {"finger": np.arange(len(found))})
    result["stable"] = np.isfinite(result["sensitivity_peak"])
    result["holds"] = result["sensitivity_peak"] <= (1.0 + MET) * result["limit"]
    return result


def _of(there: System, wanted: Requirements) -> dict[str, Any]:
    """Return one finger's worst corner, and what limits the gain."""
    grid = wanted.grid(*SEARCHED)
    # With its command at a limit the loop is open: what a law would do there says nothing of its gains.
    cases = cases_of(there, grid, _asked_for)
    if not cases:
        raise FrictionloopError("no force asked for in reach")
    # The shared grid finds where to look, within a percent; there all of it is looked at closely.
    plants, found = rough_corners(cases)
    worst = worst_corner(found)
    return {
        **worst.condition.values,
        "resonance_off": worst.off,
        "sensitivity_peak": worst.loop.sensitivity_peak(),
        "limit": worst.limit,
        "gain_factor": least_gain([each.loop for each in found], [each.limit for each in found], plants),
        "in_reach": not any(missed(each, occlusions(each)) for each in grid.systems(there)),
    }


def _asked_for(loop: LinearLoop) -> bool:
    """Tell whether a loop is at a force that is asked for: elsewhere its command stays at a limit, and cannot ring."""
    band, force_n = force_band(loop.system), loop.elements.force_n
    return band.low_n * (1.0 - ROUNDING) <= force_n <= band.high_n * (1.0 + ROUNDING)


MOST = 0.9
"""Share of the fingers for which gains are proposed beside those for all."""
NUMBERED = {"motion.load_n": "N", "friction.nominal_n": "N", "friction.susceptibility_per_um2": "um^-2"}
"""Values by which the finger of a file is held against others."""


def of_fingers(found: xr.Dataset, scaled: Any) -> Iterator[Finding]:
    """Yield what was found on fingers; ``scaled(factor)`` gives overrides with the loop gain times a factor."""
    count = found.sizes["finger"]
    seen = found.isel(finger=np.flatnonzero(found["unseen"].values == ""))
    held, rings = int(seen["holds"].sum()), int((~seen["stable"]).sum())
    if held < seen.sizes["finger"]:
        more = {"fingers": seen.sizes["finger"], "unstable": rings}
        yield Finding("PEOPLE-HOLD", "error" if held == 0 else None, held, more=more)
        yield worst_of(seen)
        yield from _gains(seen, scaled)
    missed = int((~seen["in_reach"]).sum())
    if missed:
        yield Finding("PEOPLE-REACH", value=missed, more={"fingers": count})
    reasons = Counter(said for said in found["unseen"].values.tolist() if said)
    if reasons:
        (reason, _), *_ = reasons.most_common(1)
        yield Finding("PEOPLE-UNSEEN", value=sum(reasons.values()), more={"fingers": count, "reason": reason})


def worst_of(seen: xr.Dataset) -> Finding:
    """Return the finger that needs least gain, and where."""
    worst = seen.isel(finger=int(np.nanargmin(seen["gain_factor"].values)))
    value = {str(name): worst[name].item() for name in worst.data_vars}
    names = ("slip_length_um", "speed_mm_s", "load_n", "force_n", "occluded", "resonance_off")
    there = {name: value[name] for name in names if not math.isnan(value[name])}
    where = Condition(finger=worst["finger"].item(), **there)
    return Finding("PEOPLE-WORST", value=value["sensitivity_peak"], limit=value["limit"], where=where)


def _gains(seen: xr.Dataset, scaled: Any) -> Iterator[Finding]:
    """Yield gains with which the limits hold on all fingers looked at, and on nine in ten."""
    factors = np.sort(seen["gain_factor"].values)[::-1]
    for share, factor in ((1.0, factors[-1]), (MOST, factors[math.ceil(MOST * factors.size) - 1])):
        if factor < 1.0:
            yield Finding(
                "PEOPLE-GAIN", value=float(factor), remedy=scaled(float(factor)), more={"share": 100.0 * share}
            )


def unlike(system: System, people: Sequence[Mapping[str, Any]]) -> Iterator[Finding]:
    """Yield each value by which none of some fingers is like that of the system."""
    for path, unit in NUMBERED.items():
        values = [each[path] for each in people if path in each]
        block, _, name = path.partition(".")
        own = getattr(getattr(system, block), name, None)
        if values and own is not None and not min(values) <= own <= max(values):
            ends = {"path": path, "low": min(values), "high": max(values)}
            yield Finding("PEOPLE-UNLIKE", value=own, unit=unit, more=ends)
