"""Control laws on 1,000 fingers that none of them was tuned on: twenty minutes.

``python -m studies.laws`` keeps every cell in ``studies/runs/laws.h5``, goes on where it was stopped, and writes what
*pages/laws.md* shows to ``studies/results/laws.csv``. ``python -m studies.laws references`` runs two references beside
them as well (`studies.oracle`), which takes hours.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import xarray as xr

from frictionloop.design import comparison as rooms
from frictionloop.design.comparison.law_margins import Row
from frictionloop.parameters import bench
from frictionloop.quantities.code_version import package_version
from studies.oracle import deciding

RUNS = Path(__file__).parent / "runs" / "laws.h5"
KEPT = Path(__file__).parent / "results" / "laws.csv"
SHOWN = (
    *("residual_rms_n", "hold_rms_n", "turn_peak_n", "relative_index", "over_oracle", "fall_63_s"),
    *("sensitivity_peak", "sensitivity_peak_5", "sensitivity_peak_10"),
    *("sensitivity_peak_gain", "sensitivity_peak_gain_low"),
)
CELL, KEYS = ("law", "speed_mm_s", "slip_length_um", "population", "fingers"), ("median", "worst_decile")
"""What a line of the kept file is of, and what it has of each score."""
POPULATIONS = ("capable", "median capable finger")
LAWS = ("lookup", "retuned_pi", "notch_pi", "hinf", "limit_observer")
REFERENCES = {"oracle": False, "clairvoyant": True}
"""Oracles by name, and whether each knows ahead of time."""


def whole(references: bool = False, path: Path = RUNS) -> rooms.LawRuns:
    """Return the comparison, run as far as it is not kept."""
    path.parent.mkdir(exist_ok=True)
    ran = rooms.run_laws(bench(), LAWS, path=path, resume=path.exists())
    for name, preview in REFERENCES.items() if references else ():
        with deciding(preview) as own:
            laws = {law: _given(found) for law, found in {**ran.laws, name: own}.items()}
            ran = rooms.run_laws(bench(), laws, path=path, resume=True)
    return ran


def _given(overrides: rooms.Overrides) -> rooms.Entrant:
    return lambda _: overrides


def over_oracle(scored: xr.Dataset, name: str = "oracle") -> list[Row]:
    """Return rows as of `score_rows`: the rms of each law on the sines over that of the law of a name."""
    residual = scored["residual_rms_n"]
    rows = rooms.score_rows(scored.assign(residual_rms_n=residual / residual.sel(law=name, drop=True)))
    return [row | {"score": "over_oracle", "unit": "1"} for row in rows if row["score"] == "residual_rms_n"]


def keep(rows: list[Row], kept: Path = KEPT) -> None:
    """Write what is shown at four digits, a line for each cell, below one that says where it is from."""
    cells: dict[tuple[str, ...], dict[str, str]] = {}
    for row in rows:
        if row["score"] in SHOWN and row["population"] in POPULATIONS:
            cell = cells.setdefault(tuple(str(row[name]) for name in CELL), {})
            cell |= {f"{row['score']} {key}": f"{float(row[key]):.4g}" for key in KEYS}
    scores = [f"{score} {key}" for score in SHOWN for key in KEYS]
    with kept.open("w", newline="", encoding="utf-8") as stream:
        stream.write(f"# python -m studies.laws, frictionloop {package_version()}\n")
        writer = csv.DictWriter(stream, [*CELL, *scores], lineterminator="\n")
        writer.writeheader()
        writer.writerows(dict(zip(CELL, place, strict=True)) | found for place, found in cells.items())


def main(*asked: str) -> None:
    """Run what is left, score it, and keep what is shown."""
    ran = whole("references" in asked)
    scored = rooms.scores(ran)
    loops: Any = {law: own for law, own in ran.laws.items() if law not in REFERENCES}
    rows = rooms.score_rows(scored) + (over_oracle(scored) if "references" in asked else [])
    keep(rooms.tidy_rows(rows, rooms.margin_rows(replace(ran, laws=loops))))


if __name__ == "__main__":
    main(*sys.argv[1:])
