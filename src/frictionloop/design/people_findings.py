"""What a look at other people's fingers found: on how many the limits hold, the worst of them, gains for more."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.findings import Condition, Finding
from frictionloop.parameters import System

MOST = 0.9
"""Share of the fingers for which gains are proposed beside those for all."""
NUMBERED = {"motion.load_n": "N", "friction.nominal_n": "N", "friction.susceptibility_per_um2": "um^-2"}
"""Values by which the finger of a file is held against others."""


def of_fingers(found: xr.Dataset, scaled: Any) -> Iterator[Finding]:
    """Yield what was found on fingers; ``scaled(factor)`` gives overrides with the loop gain times a factor."""
    count = found.sizes["finger"]
    seen = found.isel(finger=np.flatnonzero(found["unseen"].values == ""))
    held, rings = int(seen["holds"].sum()), int((~seen["stable"]).sum())
    if held < count:
        more = {"fingers": count, "unstable": rings}
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
