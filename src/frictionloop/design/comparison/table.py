"""A comparison as plain rows: medians and worst deciles of every score, and the margins."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.control.cost import worst_tick
from frictionloop.design.comparison.margins import robustness
from frictionloop.design.comparison.run import LawRuns
from frictionloop.design.comparison.scores import SCORES, spread

Row = dict[str, Any]
MARGINS = {
    "sensitivity_peak": "1",
    "sensitivity_peak_5": "1",
    "sensitivity_peak_10": "1",
    "sensitivity_peak_gain": "1",
    "sensitivity_peak_gain_low": "1",
    "gain_margin": "1",
    "phase_margin_deg": "deg",
    "delay_margin_s": "s",
    "stable": "1",
    "tick_cycles_m4": "1",
}
"""What the margins of a law are, with units."""


def score_rows(scored: xr.Dataset) -> list[Row]:
    """Return a row for each law, speed, contact, population and score: median and worst decile over fingers."""
    found = []
    for law in scored["law"].values:
        for v, speed in enumerate(scored["speed_mm_s"].values):
            able = scored["capable"].values[v]
            populations = {"all": np.ones_like(able), "capable": able}
            for z in scored["slip_length_um"].values:
                cell = scored.sel(law=law, speed_mm_s=speed, slip_length_um=z)
                for population, some in populations.items():
                    where = {"law": str(law), "speed_mm_s": float(speed), "slip_length_um": float(z)}
                    where |= {"population": population, "fingers": int(some.sum())}
                    found += [where | _spread(name, cell[name].values[some]) for name in SCORES]
    return found


def _spread(name: str, values: np.ndarray) -> Row:
    median, worst = spread(values, SCORES[name].larger_is_better)
    return {"score": name, "unit": SCORES[name].units, "median": median, "worst_decile": worst}


def margin_rows(comparison: LawRuns, done: Callable[[], Any] = lambda: None) -> list[Row]:
    """Return a row for each law, speed and slip length: margins for small signals, and cycles a tick.

    ``done()`` is called after each law.
    """
    found = []
    for law, overrides in comparison.laws.items():
        worst = worst_tick(comparison.system.evolve(overrides).controller.kind)
        cost = {"tick_cycles_m4": worst.cycles if worst else None}
        for speed in comparison.speeds_mm_s:
            for z in comparison.cells["slip_length_um"].values:
                where = {"law": law, "speed_mm_s": speed, "slip_length_um": float(z)}
                found.append(where | robustness(comparison, law, speed, float(z))._asdict() | cost)
        done()
    return found


def tidy_rows(scored: list[Row], margins: list[Row]) -> list[Row]:
    """Return everything in one table: margins as scores of the median finger."""
    found = list(scored)
    for row in margins:
        where = {name: row[name] for name in ("law", "speed_mm_s", "slip_length_um")}
        for name, unit in MARGINS.items():
            value = math.nan if row[name] is None else float(row[name])
            about = {"population": "median capable finger", "fingers": 1, "score": name, "unit": unit}
            found.append(where | about | {"median": value, "worst_decile": math.nan})
    return found


def value_of(rows: list[Row], key: str, **where: Any) -> float:
    """Return one number of the rows, NaN where there is none."""
    for row in rows:
        if all(row[name] == value for name, value in where.items()):
            return float(row[key])
    return math.nan
