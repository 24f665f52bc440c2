"""Times of the steps of the comparison of laws, over references and over the shortest possible: some minutes.

``python -m studies.step_times`` reads what ``studies.laws`` keeps and writes ``studies/results/step-times.csv``: over
those of skin and drive in closed form (`..._over_limit`), and over the shortest of any drive that does not turn back
(`..._over_bound`).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.design import comparison as rooms
from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.plain import occluded_at
from frictionloop.design.comparison.scores import spread
from studies.kept import keep
from studies.laws import whole
from studies.step_limits import step_limits

HEADS = ("law", "speed_mm_s", "slip_length_um", "fingers")


def over_limits(ran: rooms.Comparison, scored: xr.Dataset) -> xr.Dataset:
    """Return each step time of the scores over both limits, over law, speed, slip length and finger."""
    occluded = occluded_at(ran.system, ran.middle_s)
    parts = []
    for speed, z in itertools.product(ran.speeds_mm_s, protocol.lengths_of(ran.system)):
        at = protocol.Condition(speed, z, protocol.STEPPED)
        found = step_limits(ran.system.evolve(protocol.overrides_of(at)), ran.people, occluded)
        cell = scored.sel(speed_mm_s=[speed], slip_length_um=[z])
        ratios = {
            f"{name.removesuffix('_s')}_over_{against}": cell[name] / each
            for against, shortest in (("limit", found.reference), ("bound", found.bound))
            for name, each in shortest._asdict().items()
        }
        parts.append(xr.Dataset(ratios))
    return xr.combine_by_coords(parts)  # type: ignore[return-value]


def main() -> None:
    """Write medians and worst deciles of the capable fingers."""
    ran = whole()
    scored = rooms.scores(ran)
    found = over_limits(ran, scored)
    keep(
        "step-times",
        "step_times",
        (*HEADS, *(f"{name}{end}" for name in found for end in ("", "_worst"))),
        rows(ran, scored, found),
    )


def rows(ran: rooms.Comparison, scored: xr.Dataset, found: xr.Dataset) -> Iterator[list[Any]]:
    """Yield a row for each law, speed and slip length."""
    for law, speed, z in itertools.product(ran.laws, ran.speeds_mm_s, protocol.lengths_of(ran.system)):
        able = scored["capable"].sel(speed_mm_s=speed).values
        cell = found.sel(law=law, speed_mm_s=speed, slip_length_um=z)
        both = (spread(np.asarray(values.values)[able], larger_is_better=False) for values in cell.values())
        yield [law, speed, z, int(able.sum()), *(f"{value:.4g}" for pair in both for value in pair)]


if __name__ == "__main__":
    main()
