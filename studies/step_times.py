"""Times of the steps of the comparison of laws, over references and over the shortest possible: some minutes.

``python -m studies.step_times`` reads what ``studies.laws`` keeps and writes ``studies/results/step-times.csv``: over
those of skin and drive in closed form (`..._over_limit`), and over the shortest of any drive that does not turn back
(`..._over_bound`).
"""

from __future__ import annotations

import csv
import itertools
from pathlib import Path

import numpy as np
import xarray as xr

from frictionloop.design import comparison as rooms
from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.plain import occluded_at
from frictionloop.design.comparison.scores import spread
from frictionloop.quantities.version import package_version
from studies.laws import whole
from studies.step_limits import step_limits

KEPT = Path(__file__).parent / "results" / "step-times.csv"
HEADS = ("law", "speed_mm_s", "contact", "population", "fingers", "score", "unit", "median", "worst_decile")


def over_limits(ran: rooms.Comparison, scored: xr.Dataset) -> xr.Dataset:
    """Return each step time of the scores over both limits, over law, speed, contact and finger."""
    occluded = occluded_at(ran.system, ran.middle_s)
    parts = []
    for speed, contact in itertools.product(ran.speeds_mm_s, protocol.CONTACTS):
        at = protocol.Condition(speed, contact, protocol.STEPPED)
        found = step_limits(ran.system.evolve(protocol.overrides_of(at)), ran.people, occluded)
        cell = scored.sel(speed_mm_s=[speed], contact=[contact])
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
    with KEPT.open("w", newline="", encoding="utf-8") as stream:
        stream.write(f"# python -m studies.step_times, frictionloop {package_version()}\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(HEADS)
        for law, speed, contact in itertools.product(ran.laws, ran.speeds_mm_s, protocol.CONTACTS):
            able = scored["capable"].sel(speed_mm_s=speed).values
            cell = found.sel(law=law, speed_mm_s=speed, contact=contact)
            for name, values in cell.data_vars.items():
                both = spread(np.asarray(values.values)[able], larger_is_better=False)
                where = (law, speed, contact, "capable", int(able.sum()), name, "1")
                writer.writerow([*where, *(f"{value:.4g}" for value in both)])


if __name__ == "__main__":
    main()
